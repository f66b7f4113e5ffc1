"""Topics about EMCY: its objects, before and after an error that is provoked."""

from collections.abc import Iterator
from contextlib import contextmanager

from canopen_twins.bus import identifiers
from canopen_twins.bus.frame import Frame
from canopen_twins.conform.pdo import EVENTS, RPDOS, obtain
from canopen_twins.conform.tester import PATIENCE, START, Failed, NotApplicable, Tester
from canopen_twins.conform.topic import Group
from canopen_twins.slave.object import Abort

EMCY = Group(5, "EMCY", "emcy")

REGISTER, HISTORY, COB_ID = 0x1001, 0x1003, 0x1014
CODES = "CiA 301, 7.5.2.6"


@EMCY.topic("CiA 301, 7.5.2.17")
def identifier_is_predefined(tester: Tester) -> None:
    """The identifier of EMCY is 80h and the node id."""
    tester.need(COB_ID)
    usual, told = identifiers.emcy(tester.slave.node_id), tester.number(COB_ID)
    if told != usual:
        raise Failed(f"0x1014 is {told:X}h instead of {usual:X}h")


@EMCY.topic("CiA 301, 7.5.2.2")
def register_is_empty(tester: Tester) -> None:
    """The error register is 0 after a reset."""
    tester.need(REGISTER)
    if register := tester.number(REGISTER):
        raise Failed(f"0x1001 is {register:02X}h")


@EMCY.topic(CODES)
def history_is_empty(tester: Tester) -> None:
    """The error history tells as many errors as it has, none of them is empty."""
    tester.need(HISTORY)
    for subindex in range(1, min(tester.number(HISTORY), 0xFE) + 1):
        if not tester.number(HISTORY, subindex) & 0xFFFF:
            raise Failed(f"0x1003:{subindex:02X} is empty, 0x1003:00 is {tester.number(HISTORY)}")


@contextmanager
def _provoked(tester: Tester) -> Iterator[Frame]:
    """Something is wrong, and this is what the slave has told of it.

    Raises:
        NotApplicable: there is no way to let something go wrong.
    """
    tester.need(COB_ID)
    can_id = tester.number(COB_ID) & identifiers.CAN_ID
    for provocation in tester.slave.provocations:
        tester.prepare()
        with provocation():
            for frame in tester.listen(PATIENCE):
                if frame.can_id == can_id:
                    yield frame
                    return
    tester.prepare()
    pdo = obtain(tester, RPDOS, EVENTS)
    tester.nmt(START)
    tester.forget()
    tester.send(pdo.can_id, bytes(pdo.size - 1))
    for frame in tester.listen(PATIENCE):
        if frame.can_id == can_id:
            yield frame
            return
    raise NotApplicable("there is no error that could be provoked over the bus", COB_ID)


@EMCY.topic("CiA 301, 7.2.7")
def error_is_told(tester: Tester) -> None:
    """An error is told once, in eight bytes, with its code and the error register."""
    with _provoked(tester) as told:
        code = int.from_bytes(told.data[:2], "little")
        if len(told.data) != 8 or not code:
            raise Failed(f"{told} is no emergency of eight bytes")
        if (register := tester.number(REGISTER)) != told.data[2]:
            raise Failed(f"0x1001 is {register:02X}h, {told} says {told.data[2]:02X}h")
        if not register & 1:
            raise Failed(f"bit 0 of 0x1001 is not set with {told}")
        for frame in tester.listen(PATIENCE):
            if frame == told:
                raise Failed(f"{frame} is told twice")


@EMCY.topic(CODES)
def error_is_in_the_history(tester: Tester) -> None:
    """An error that was told is the newest of the error history."""
    tester.need(HISTORY, 1)
    with _provoked(tester) as told:
        code = int.from_bytes(told.data[:2], "little")
        if tester.number(HISTORY) < 1:
            raise Failed(f"0x1003:00 is 0 after {told}")
        if (newest := tester.number(HISTORY, 1) & 0xFFFF) != code:
            raise Failed(f"0x1003:01 is {newest:04X}h after {told}")


@EMCY.topic(CODES)
def history_is_cleared(tester: Tester) -> None:
    """0 clears the error history, and no other value is taken: 06090030h."""
    tester.need_writable(HISTORY)
    tester.expect_refusal((HISTORY, 0), 1, Abort.INVALID_VALUE, Abort.TOO_HIGH)
    tester.write((HISTORY, 0), 0)
    if count := tester.number(HISTORY):
        raise Failed(f"0x1003:00 is {count} after 0 was written")


GROUPS = (EMCY,)
