"""What a master of node 99 sends, in the notation of cansend."""

from contextlib import contextmanager

import pytest
from canopen import SdoAbortedError

START, STOP, ENTER_PREOP = "000#0163", "000#0263", "000#8063"
RESET_NODE, RESET_COMMUNICATION = "000#8163", "000#8263"
SAVE, LOAD = "663#2310100173617665", "663#231110016C6F6164"
SAVED, LOADED = ["5E3#6010100100000000"], ["5E3#6011100100000000"]
RELEASED, LOCKED = "263#0F", "263#00"  # RPDO 1
CANOPEN = 8  # bit of 0x2002:02
CONFIGURE, WAIT = "7E5#0401000000000000", "7E5#0400000000000000"
INQUIRE_NODE_ID = "7E5#5E00000000000000"


@contextmanager
def refused(code):
    """The SDO access inside is aborted with this code."""
    with pytest.raises(SdoAbortedError) as abort:
        yield
    assert hex(abort.value.code) == hex(code)


def ask(bench, index, subindex=0):
    """The answer to an SDO upload request, as it is on the bus."""
    return bench.send(f"663#40{index & 0xFF:02X}{index >> 8:02X}{subindex:02X}00000000")


def aborted(answer):
    """Index, sub-index and code of an abort."""
    (frame,) = answer
    data = bytes.fromhex(frame.removeprefix("5E3#"))
    assert data[0] == 0x80, frame
    return int.from_bytes(data[1:3], "little"), data[3], int.from_bytes(data[4:], "little")


def value(bench, subindex, index=0x2002):
    return bench.sdo[index][subindex].raw


def put(bench, values, index=0x2002):
    """Write entries of an object, one after the other."""
    for subindex, new in values.items():
        bench.sdo[index][subindex].raw = new


def status(bench):
    """0x6000:01."""
    return value(bench, 1, 0x6000)


def release(bench, **setpoints):
    """Let CANopen release, set something, release by SDO and wait for the end of the ramp."""
    put(bench, {0x02: CANOPEN, 0x08: 20_000, **setpoints})
    bench.sdo[0x6200][1].raw = 0x0F
    bench.run(1.0)


def restart(bench, how):
    if how == "power":
        bench.power_off()
        bench.power_on()
    else:
        bench.send(how)
