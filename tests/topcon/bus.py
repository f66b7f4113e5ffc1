"""What a master of node 5 sends, in the notation of cansend."""

from contextlib import contextmanager

import pytest
from canopen import SdoAbortedError

START, STOP, ENTER_PREOP = "000#0105", "000#0205", "000#8005"
RESET_NODE, RESET_COMMUNICATION = "000#8105", "000#8205"
SYNC = "080#"


@contextmanager
def refused(code):
    """The SDO access inside is aborted with this code."""
    with pytest.raises(SdoAbortedError) as abort:
        yield
    assert hex(abort.value.code) == hex(code)


def run(bench, voltage=4000, current=4000, power=4000, resistance=0):
    """Set values in parts, then RUN."""
    bench.sdo["Voltage reference"].raw = voltage
    bench.sdo["Current reference"].raw = current
    bench.sdo["Power reference"].raw = power
    bench.sdo["Internal resistance reference"].raw = resistance
    bench.sdo["Run command"].raw = 1


def state_of_output(bench):
    """0x2023 as it is read over the bus."""
    return bench.sdo["State of output"].raw


def read(bench, index, subindex=0):
    """The answer to an SDO upload request, as it is on the bus."""
    return bench.send(f"605#40{index & 0xFF:02X}{index >> 8:02X}{subindex:02X}00000000")


def aborted(answer):
    """Index, sub-index and code of an abort; none for any other answer."""
    (frame,) = answer
    data = bytes.fromhex(frame.removeprefix("585#"))
    if data[0] != 0x80:
        return None
    return int.from_bytes(data[1:3], "little"), data[3], int.from_bytes(data[4:], "little")


def emcy(code, register, detail):
    """An emergency of node 5."""
    data = code.to_bytes(2, "little") + bytes([register]) + detail.to_bytes(5, "little")
    return f"085#{data.hex().upper()}"


def reset(bench):
    """Reset the errors (command 2); the last frame that follows."""
    bench.sdo["Run command"].raw = 2
    return bench.sent[-1]
