"""Topics about SYNC, of a slave that follows it and of one that produces it."""

from canopen_twins.bus import identifiers
from canopen_twins.conform.pdo import TPDOS, obtain, produce_sync
from canopen_twins.conform.store import expect_stored
from canopen_twins.conform.tester import SILENCE, START, Failed, Tester
from canopen_twins.conform.topic import Group
from canopen_twins.slave.object import Abort

SYNC = Group(6, "SYNC", "pdo")

COB_ID, PERIOD, OVERFLOW = 0x1005, 0x1006, 0x1019
COB_RULES, PERIOD_RULES = "CiA 301, 7.5.2.8", "CiA 301, 7.5.2.9"
COUNTER_RULES = "CiA 301, 7.5.2.22"
OTHER = 0x6D0
CYCLE = 100_000  # microseconds
LATER = (Abort.DEVICE_STATE, 0x08000000)


@SYNC.topic(COB_RULES)
def identifier_is_predefined(tester: Tester) -> None:
    """The identifier of SYNC is 80h."""
    tester.need(COB_ID)
    if (told := tester.number(COB_ID) & identifiers.CAN_ID) != identifiers.SYNC:
        raise Failed(f"0x1005 is {told:X}h")


@SYNC.topic(COB_RULES)
def other_identifier_is_followed(tester: Tester) -> None:
    """A synchronous TPDO follows a SYNC with another identifier when it has got one."""
    tester.need_writable(COB_ID)
    pdo = obtain(tester, TPDOS, [1])
    produce_sync(tester)
    tester.write((COB_ID, 0), OTHER)
    tester.nmt(START)
    tester.forget()
    tester.send(identifiers.SYNC)
    tester.expect_silence(pdo.can_id, "follows the old SYNC")
    tester.send(OTHER)
    tester.hear(pdo.can_id)


@SYNC.topic(COB_RULES)
def long_identifiers_are_refused(tester: Tester) -> None:
    """A SYNC with bits of an identifier that has 11 is refused: 06090030h."""
    tester.need_writable(COB_ID)
    tester.expect_refusal((COB_ID, 0), 0x80 | 1 << 11, Abort.INVALID_VALUE)


def _produce(tester: Tester) -> None:
    """Let the slave send SYNC.

    Raises:
        NotApplicable: it is no producer.
    """
    tester.need_writable(PERIOD)
    tester.need_writable(COB_ID)
    tester.write((PERIOD, 0), CYCLE)
    tester.write((COB_ID, 0), identifiers.SYNC | identifiers.PRODUCES)


@SYNC.topic(PERIOD_RULES)
def sync_is_produced(tester: Tester) -> None:
    """SYNC is sent with the cycle period, in Pre-operational and Operational."""
    _produce(tester)
    for _ in range(2):
        sent = tester.count(identifiers.SYNC, 1.05)
        if not 8 <= sent <= 12:
            raise Failed(f"{sent} in 1 s with a period of {CYCLE} us")
        tester.nmt(START)


@SYNC.topic(PERIOD_RULES)
def sync_is_no_longer_produced(tester: Tester) -> None:
    """A period of 0 and bit 30 of 0x1005 end SYNC."""
    _produce(tester)
    tester.write((PERIOD, 0), 0)
    tester.forget()
    tester.expect_silence(identifiers.SYNC, "is sent with a period of 0")
    tester.write((PERIOD, 0), CYCLE)
    tester.write((COB_ID, 0), identifiers.SYNC)
    tester.forget()
    tester.expect_silence(identifiers.SYNC, "is sent without bit 30")


@SYNC.topic(COUNTER_RULES)
def counter_runs_over(tester: Tester) -> None:
    """The counter of SYNC goes from 1 to its overflow value, and begins anew."""
    tester.need_writable(OVERFLOW)
    tester.write((OVERFLOW, 0), 3)
    _produce(tester)
    counted = [frame.data for frame in tester.listen(0.75) if frame.can_id == identifiers.SYNC][:6]
    if counted != [bytes([number % 3 + 1]) for number in range(6)]:
        raise Failed(f"the counter is {b' '.join(counted).hex(' ')}")


@SYNC.topic(COUNTER_RULES)
def counter_has_its_range(tester: Tester) -> None:
    """The counter overflow value is 0 or 2 to 240, and others are refused: 06090030h."""
    tester.need_writable(OVERFLOW)
    for number in (2, 240, 0):
        tester.write((OVERFLOW, 0), number)
    for number in (1, 241, 255):
        codes = (Abort.INVALID_VALUE, Abort.TOO_HIGH, Abort.TOO_LOW)
        tester.expect_refusal((OVERFLOW, 0), number, *codes)


@SYNC.topic(COUNTER_RULES)
def counter_is_kept_while_sync_runs(tester: Tester) -> None:
    """The counter overflow value cannot be changed while there is a period: 08000022h."""
    tester.need_writable(OVERFLOW)
    tester.need_writable(PERIOD)
    tester.write((PERIOD, 0), CYCLE)
    tester.expect_refusal((OVERFLOW, 0), 10, *LATER)


@SYNC.topic("CiA 301, 7.2.5")
def is_followed_in_operational_only(tester: Tester) -> None:
    """A synchronous TPDO follows SYNC in Operational, and not before."""
    pdo = obtain(tester, TPDOS, [1])
    produce_sync(tester)
    tester.forget()
    tester.send(identifiers.SYNC)
    tester.expect_silence(pdo.can_id, "follows SYNC in pre-operational", SILENCE)
    tester.nmt(START)
    tester.forget()
    tester.send(identifiers.SYNC)
    tester.hear(pdo.can_id)


@SYNC.topic("CiA 301, 7.5.2.13")
def identifier_is_stored(tester: Tester) -> None:
    """The identifier of SYNC outlives a reset of the node when it was stored."""
    tester.need_writable(COB_ID)
    expect_stored(tester, {(COB_ID, 0): OTHER})


GROUPS = (SYNC,)
