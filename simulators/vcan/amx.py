"""What user-mode Linux needs on a CPU with AMX.

Its kernel 6.1 has room for 2696 bytes of extended registers (x87 to AVX-512); with AMX the host has
11008 and refuses to set a part, and the guest aborts. Without that interface it falls back to
the 512 bytes of FXSAVE. Then the upper halves of the AVX registers stay as they are when threads of
one process take turns, so that nothing in the guest may rely on them.
"""

import ctypes
import struct
from errno import EINVAL
from pathlib import Path

from simulators.vcan import process

LOAD, IF_EQUAL, RETURN = 0x20, 0x15, 0x06  # classic BPF
ALLOW, FAIL = 0x7FFF0000, 0x00050000
NUMBER, FIRST, THIRD = 0, 16, 32  # of a system call and its arguments, in struct seccomp_data
PTRACE, GETREGSET, SETREGSET, NT_X86_XSTATE = 101, 0x4204, 0x4205, 0x202
PR_SET_SECCOMP, PR_SET_NO_NEW_PRIVS, SECCOMP_MODE_FILTER = 22, 38, 2

NO_XSTATE = (  # code, how many to skip if equal, and if not, value
    (LOAD, 0, 0, NUMBER),
    (IF_EQUAL, 0, 6, PTRACE),
    (LOAD, 0, 0, FIRST),
    (IF_EQUAL, 1, 0, GETREGSET),
    (IF_EQUAL, 0, 3, SETREGSET),
    (LOAD, 0, 0, THIRD),
    (IF_EQUAL, 0, 1, NT_X86_XSTATE),
    (RETURN, 0, 0, FAIL | EINVAL),
    (RETURN, 0, 0, ALLOW),
)

WITHOUT_AVX = {
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX,-AVX2,-AVX_Fast_Unaligned_Load"
    ",-AVX512F,-AVX512VL,-AVX512BW",
    "OPENSSL_ia32cap": "~0x1000000000000000:~0xC0230020",  # AVX; AVX2, AVX-512
}
"""What keeps libc and libcrypto in the guest from AVX."""


def present() -> bool:
    """Whether the CPU has AMX."""
    return " amx_tile" in Path("/proc/cpuinfo").read_text("ascii")


def hide_xstate() -> None:
    """Let `ptrace` refuse the extended registers as a whole, for this process and its children."""
    code = ctypes.create_string_buffer(b"".join(struct.pack("HBBI", *line) for line in NO_XSTATE))
    program = struct.pack("HxxxxxxP", len(NO_XSTATE), ctypes.addressof(code))
    process.control(PR_SET_NO_NEW_PRIVS, 1)
    process.control(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, program)
