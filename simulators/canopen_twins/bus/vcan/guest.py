"""What user-mode Linux needs on a CPU with AMX.

Its kernel 6.1 has room for 2696 bytes of extended registers (x87 to AVX-512); with AMX the host has
11008 and refuses to set a part, and the guest aborts. Without that interface it falls back to
the 512 bytes of FXSAVE. Then the upper halves of the AVX registers stay as they are when threads of
one process take turns, so that nothing in the guest may rely on them.
"""

import ctypes
import os
import platform
import shlex
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from errno import EINVAL
from importlib.resources import files
from pathlib import Path

from canopen_twins.bus.vcan import process
from canopen_twins.errors import UserError

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


NEEDED = {"linux.uml": "user-mode-linux", "ip": "iproute2", "insmod": "kmod"}
MEMORY = 1 << 30  # bytes of the guest, in a file of the host
PR_SET_PDEATHSIG = 1
NO_EXEC = getattr(os, "ST_NOEXEC", 0)
LAST_WORDS = 3  # lines of the console that are shown when the guest does not come up


def run(command: Sequence[str], limit: float, out: Path | None = None) -> int:
    """Run a command in a guest and return its exit status, 124 if `limit` seconds are too short.

    Raises:
        UserError: something the guest needs is missing, `out` can be no folder, or the guest did
            not come up.
    """
    _check_host()
    if out is not None:
        _make(out)
    memory = _folder_for_memory()
    with tempfile.TemporaryDirectory(prefix="vcan-") as folder:
        work = Path(folder)
        _lay_out(work, command, out)
        return _status(work) if _boot(work, memory, limit) else process.out_of_time(limit)


def _make(out: Path) -> None:
    try:
        out.mkdir(exist_ok=True)
    except OSError as failure:
        raise UserError(f"{out} is no folder: {failure.strerror}") from failure


def _check_host() -> None:
    if sys.platform != "linux" or platform.machine() != "x86_64":
        raise UserError("there is no vcan0, and a guest that has one needs Linux on x86_64")
    path = f"{os.environ.get('PATH', os.defpath)}:/usr/sbin:/sbin"
    missing = [tool for tool in NEEDED if shutil.which(tool, path=path) is None]
    if missing:
        packages = " ".join(NEEDED[tool] for tool in missing)
        raise UserError(
            f"there is no vcan0, and no {', '.join(missing)} for a guest that has one:"
            f" apt-get install --no-install-recommends {packages}"
        )


def _folder_for_memory() -> str:
    """/dev/shm is fastest, but containers often make it small, or not executable."""
    folders = ["/dev/shm", tempfile.gettempdir()]
    for folder in filter(os.path.isdir, folders):
        about = os.statvfs(folder)
        if not about.f_flag & NO_EXEC and about.f_bavail * about.f_frsize >= MEMORY:
            return folder
    raise UserError(
        f"the guest needs {MEMORY >> 20} MB in {' or '.join(folders)}, not mounted noexec"
    )


def _lay_out(work: Path, command: Sequence[str], out: Path | None) -> None:
    """What `init` finds beside itself."""
    init = work / "init"
    init.write_bytes((files("canopen_twins.bus.vcan") / "init").read_bytes())
    init.chmod(0o755)
    variables = [f"{name}={value}" for name, value in _environment().items()]
    words = ["exec", "env", "-i", "-C", str(Path.cwd()), *variables, *command]
    (work / "command").write_text(shlex.join(words), "utf-8", "surrogateescape")
    if out is not None:
        (work / "out").symlink_to(out.resolve())


def _environment() -> Mapping[str, str]:
    """That of the host, but colours only where there is somebody to see them."""
    terminal = {} if sys.stdout.isatty() else {"TERM": "dumb"}
    return {**os.environ, **terminal, **_restraints()}


def _restraints() -> Mapping[str, str]:
    return WITHOUT_AVX if present() else {}


def _boot(work: Path, memory: str, limit: float) -> bool:
    """Run the guest; whether it has ended in time."""
    command = [
        "linux.uml",
        f"mem={MEMORY >> 20}M",
        f"uml_dir={work}/",
        *("rootfstype=hostfs", "rootflags=/", "ro", f"init={work}/init"),
        # its own console is the file, the terminals of the command are the pipes
        *("con=null", "con0=null,fd:0", "con1=null,fd:1", "con2=null,fd:2", "quiet"),
        *(f"{name}={value}" for name, value in _restraints().items()),
    ]
    with (
        (work / "console").open("wb") as console,
        process.group(
            command,
            stdin=console,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={**os.environ, "TMPDIR": memory},
            preexec_fn=_prepare,
        ) as guest,
    ):
        return process.relay(guest, limit)


def _prepare() -> None:
    """One core makes a guest three times as fast: its processes take turns anyway."""
    cores = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {cores[os.getpid() % len(cores)]})
    process.control(PR_SET_PDEATHSIG, signal.SIGTERM)
    if present():
        hide_xstate()


def _status(work: Path) -> int:
    try:
        return int((work / "status").read_text("ascii"))
    except FileNotFoundError:
        console = (work / "console").read_text("utf-8", "replace").splitlines()
        words = " | ".join(console[-LAST_WORDS:])
        raise UserError(f"the guest did not come up: {words or 'it said nothing'}") from None
