"""Topics about TPDOs: when they are sent, and when not."""

from canopen_twins.bus import identifiers
from canopen_twins.conform.pdo import (
    COB_ID,
    EVENT_TIMER,
    EVENTS,
    INHIBIT_TIME,
    TPDOS,
    TYPE,
    Pdo,
    expect_none,
    need_records,
    obtain,
    produce_sync,
    switch_off,
    valid,
)
from canopen_twins.conform.tester import (
    PATIENCE,
    SILENCE,
    START,
    STOP,
    Failed,
    NotApplicable,
    Tester,
)
from canopen_twins.conform.topic import Group
from canopen_twins.slave.object import Abort

TPDO = Group(3, "PDO", "pdo")

TYPES, RULES = "CiA 301, 7.2.2.2", "CiA 301, 7.5.2.37"
SYNC_OF_EACH, SYNC_OF_THIRD, ACYCLIC, SYNC_RTR, EVENT_RTR = [1], [3], [0], [252], [253]
EVENT_TIME = 100  # milliseconds
RESERVED = (241, 251)  # types


def _started(tester: Tester, pdo: Pdo) -> Pdo:
    """Begin Operational; what is sent at once is of no interest."""
    produce_sync(tester)
    tester.nmt(START)
    for _ in tester.listen(SILENCE):
        pass
    return pdo


def _sync(tester: Tester, pdo: Pdo) -> int:
    """How many come with one SYNC."""
    tester.send(identifiers.SYNC)
    return tester.count(pdo.can_id, SILENCE / 3)


def _expect(tester: Tester, told: object, wanted: object, what: str) -> None:
    if told != wanted:
        raise Failed(f"{what}: {told} instead of {wanted}")


@TPDO.topic(TYPES)
def begins_with_operational(tester: Tester) -> None:
    """An event-driven TPDO is sent when Operational begins."""
    pdo = obtain(tester, TPDOS, EVENTS)
    tester.forget()
    tester.nmt(START)
    tester.hear(pdo.can_id)


@TPDO.topic(TYPES)
def has_its_length(tester: Tester) -> None:
    """A TPDO is as long as its mapping."""
    pdos = {pdo.can_id: pdo for pdo in valid(tester, TPDOS) if pdo.parts}
    if not pdos:
        raise NotApplicable("no TPDO is in force", TPDOS.start)
    tester.forget()
    tester.nmt(START)
    tester.send(identifiers.SYNC)
    for can_id in pdos:
        tester.send(can_id, remote=True)
    heard = [frame for frame in tester.listen(PATIENCE) if not frame.remote]
    for frame in heard:
        if frame.can_id in pdos and len(frame.data) != pdos[frame.can_id].size:
            raise Failed(f"{frame} instead of {pdos[frame.can_id].size} bytes")
    if not any(frame.can_id in pdos for frame in heard):
        raise Failed(f"no TPDO in {PATIENCE:g} s, with SYNC and when asked")


@TPDO.topic(RULES)
def has_event_timer(tester: Tester) -> None:
    """The event timer sends an event-driven TPDO again and again."""
    pdo = _started(tester, obtain(tester, TPDOS, EVENTS, {EVENT_TIMER: EVENT_TIME}))
    sent = tester.count(pdo.can_id, 1.05)
    if not 8 <= sent <= 12:
        raise Failed(f"{sent} in 1 s with an event timer of {EVENT_TIME} ms")


@TPDO.topic(RULES)
def has_inhibit_time(tester: Tester) -> None:
    """The inhibit time is the shortest from one event-driven TPDO to the next."""
    settings = {INHIBIT_TIME: 2000, EVENT_TIMER: 50}
    pdo = _started(tester, obtain(tester, TPDOS, EVENTS, settings))
    sent = tester.count(pdo.can_id, 1.5)  # a busy machine may bring two of them together
    if not 2 <= sent <= 10:
        raise Failed(f"{sent} in 1.5 s with an inhibit time of 0.2 s, an event timer of 50 ms")


@TPDO.topic(TYPES)
def follows_sync(tester: Tester) -> None:
    """Type 1 is sent at every SYNC, and only then."""
    pdo = _started(tester, obtain(tester, TPDOS, SYNC_OF_EACH))
    _expect(tester, tester.count(pdo.can_id, SILENCE), 0, "TPDOs without SYNC")
    _expect(tester, [_sync(tester, pdo) for _ in range(3)], [1, 1, 1], "TPDOs at three SYNCs")


@TPDO.topic(TYPES)
def follows_third_sync(tester: Tester) -> None:
    """Type 3 is sent at every third SYNC."""
    pdo = _started(tester, obtain(tester, TPDOS, SYNC_OF_THIRD))
    sent = [_sync(tester, pdo) for _ in range(9)]
    first = sent.index(1) if 1 in sent else 9
    wanted = [int(number % 3 == first % 3) for number in range(9)]
    if first > 2 or sent != wanted:
        raise Failed(f"TPDOs at nine SYNCs: {sent}")


@TPDO.topic(TYPES)
def takes_cyclic_types(tester: Tester) -> None:
    """Types 1 to 240 can be set if one of them can."""
    pdo = obtain(tester, TPDOS, range(1, 241))
    tester.need_writable(pdo.record, TYPE)
    cob_id = switch_off(tester, pdo)
    for number in (1, 2, 120, 239, 240):
        tester.write((pdo.record, TYPE), number)
    tester.write((pdo.record, COB_ID), cob_id)


@TPDO.topic(TYPES)
def is_acyclic(tester: Tester) -> None:
    """Type 0 is sent at a SYNC after an event, and never without SYNC."""
    pdo = _started(tester, obtain(tester, TPDOS, ACYCLIC))
    _expect(tester, tester.count(pdo.can_id, SILENCE), 0, "TPDOs without SYNC")
    if (sent := max(_sync(tester, pdo) for _ in range(3))) > 1:
        raise Failed(f"{sent} TPDOs at one SYNC")


@TPDO.topic(TYPES)
def is_asked_for(tester: Tester) -> None:
    """Type 253 is sent when it is asked for, and only then."""
    pdo = _started(tester, obtain(tester, TPDOS, EVENT_RTR))
    _expect(tester, _sync(tester, pdo), 0, "TPDOs at a SYNC")
    tester.send(pdo.can_id, remote=True)
    _expect(tester, tester.count(pdo.can_id, SILENCE), 1, "TPDOs for one request")


@TPDO.topic(TYPES)
def is_sampled_and_asked_for(tester: Tester) -> None:
    """Type 252 is sampled at SYNC, and sent when it is asked for."""
    pdo = _started(tester, obtain(tester, TPDOS, SYNC_RTR))
    _expect(tester, _sync(tester, pdo), 0, "TPDOs at a SYNC")
    tester.send(pdo.can_id, remote=True)
    _expect(tester, tester.count(pdo.can_id, SILENCE), 1, "TPDOs for one request")


@TPDO.topic(RULES)
def may_not_be_asked_for(tester: Tester) -> None:
    """A TPDO with bit 30 of its COB-ID set is not sent when it is asked for."""
    pdo = obtain(tester, TPDOS, [253, 252])
    cob_id = switch_off(tester, pdo)
    address = pdo.record, COB_ID
    if code := tester.try_write(address, cob_id | identifiers.NO_RTR):
        raise NotApplicable(f"bit 30 cannot be set: {code:08X}h", pdo.record)
    _started(tester, pdo)
    tester.send(pdo.can_id, remote=True)
    tester.expect_silence(pdo.can_id, "is sent though it may not be asked for")


@TPDO.topic("CiA 301, 7.3.2.2.5")
def is_silent_in_pre_operational(tester: Tester) -> None:
    """No TPDO is sent in Pre-operational, at whatever occasion."""
    pdo = obtain(tester, TPDOS, [1, 253, 254, 255])
    expect_none(tester, {pdo.can_id}, "in pre-operational")


@TPDO.topic("CiA 301, 7.3.2.2.5")
def is_silent_in_stopped(tester: Tester) -> None:
    """No TPDO is sent in Stopped, at whatever occasion."""
    pdo = obtain(tester, TPDOS, [1, 253, 254, 255])
    tester.nmt(START)
    tester.nmt(STOP)
    expect_none(tester, {pdo.can_id}, "in stopped")


@TPDO.topic(RULES)
def is_switched_off(tester: Tester) -> None:
    """A TPDO with bit 31 of its COB-ID set is not sent."""
    pdo = obtain(tester, TPDOS, [1, 253, 254, 255])
    switch_off(tester, pdo)
    tester.nmt(START)
    expect_none(tester, {pdo.can_id}, "with bit 31")


@TPDO.topic(RULES)
def takes_other_identifier(tester: Tester) -> None:
    """A TPDO is sent with another identifier when it has got one, and no longer with the old."""
    pdo = obtain(tester, TPDOS, [1, 254, 255, 253])
    cob_id = switch_off(tester, pdo)
    other = 0x6D0
    tester.write((pdo.record, COB_ID), cob_id & ~identifiers.CAN_ID | other)
    tester.forget()
    tester.nmt(START)
    tester.send(identifiers.SYNC)
    tester.send(other, remote=True)
    ids = {frame.can_id for frame in tester.listen(PATIENCE) if not frame.remote}
    if other not in ids or pdo.can_id in ids:
        raise Failed(f"{other:03X} was set, and of both there was {ids & {other, pdo.can_id}}")


def expect_reserved_refused(tester: Tester, area: range) -> None:
    """Transmission types that are reserved are refused."""
    for index in need_records(tester, area):
        entry = tester.entry(index, TYPE)
        if entry is not None and entry.writable:
            before = tester.number(index, TYPE)
            for number in RESERVED:
                tester.expect_refusal((index, TYPE), number, Abort.INVALID_VALUE, Abort.TOO_HIGH)
            _expect(tester, tester.number(index, TYPE), before, "type after a refusal")
            return
    raise NotApplicable("no transmission type can be written", area.start)


@TPDO.topic(RULES)
def refuses_reserved_types(tester: Tester) -> None:
    """Transmission types 241 to 251 of a TPDO are refused: 06090030h."""
    expect_reserved_refused(tester, TPDOS)


GROUPS = (TPDO,)
