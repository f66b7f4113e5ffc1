"""Topics about heartbeat and node guarding: who is watched, and who watches."""

from canopen_twins.bus import identifiers
from canopen_twins.conform.tester import (
    PATIENCE,
    RESET_COMMUNICATION,
    SILENCE,
    START,
    STOP,
    Failed,
    NotApplicable,
    Tester,
)
from canopen_twins.conform.topic import Group
from canopen_twins.slave.nmt import STATE_BYTE
from canopen_twins.slave.object import Abort
from canopen_twins.slave.service import State

CONTROL = Group(7, "Guarding and heartbeat", "heartbeat")

PRODUCER, CONSUMER, GUARD_TIME, LIFE_TIME, REACTION = 0x1017, 0x1016, 0x100C, 0x100D, 0x1029
HEARTBEATS, CONSUMERS = "CiA 301, 7.2.8.3.2", "CiA 301, 7.5.2.19"
GUARDING, PRODUCERS = "CiA 301, 7.2.8.3.1", "CiA 301, 7.5.2.20"
REACTIONS = "CiA 301, 7.5.2.25"
TOGGLE = 0x80
TIME = 200  # milliseconds
HEARTBEAT_LOST = 0x8130
BEATS = 0.05  # seconds from one heartbeat of the tester to the next


def _need_producer(tester: Tester) -> float:
    """The period of a heartbeat that runs, in seconds.

    Raises:
        NotApplicable: there is none.
    """
    tester.need(PRODUCER)
    if not (period := tester.watch()):
        raise NotApplicable("there is no heartbeat, and none can be set", PRODUCER)
    return period


@CONTROL.topic(HEARTBEATS)
def heartbeat_has_its_period(tester: Tester) -> None:
    """The heartbeat comes with the period of 0x1017."""
    period = _need_producer(tester)
    tester.forget()
    times = tester.times(tester.error_control, 6.2 * period)
    if len(times) < 5:
        raise Failed(f"{len(times)} heartbeats in {6.2 * period:g} s")
    if abs((times[-1] - times[0]) / (len(times) - 1) - period) > 0.1 * period + 0.01:
        raise Failed(f"{(times[-1] - times[0]) / (len(times) - 1):.3f} s instead of {period:g} s")


@CONTROL.topic(PRODUCERS)
def heartbeat_is_switched_off(tester: Tester) -> None:
    """0 in 0x1017 ends the heartbeat."""
    tester.need_writable(PRODUCER)
    _need_producer(tester)
    tester.write((PRODUCER, 0), 0)
    tester.forget()
    tester.expect_silence(tester.error_control, "is sent with 0x1017 = 0", 1.5)


@CONTROL.topic(PRODUCERS)
def heartbeat_takes_every_time(tester: Tester) -> None:
    """0x1017 takes 1 to 65535 ms."""
    tester.need_writable(PRODUCER)
    for time in (65535, 1000, 255, 10, 1, 0):
        tester.write((PRODUCER, 0), time)
        if (told := tester.number(PRODUCER)) != time:
            raise Failed(f"0x1017 is {told} after {time} was written")


def _expect_told(tester: Tester, command: int | None, state: State) -> None:
    period = _need_producer(tester)
    if command is not None:
        tester.nmt(command)
    tester.expect_state(state, period)


@CONTROL.topic(HEARTBEATS)
def heartbeat_tells_pre_operational(tester: Tester) -> None:
    """The heartbeat tells 7Fh in Pre-operational."""
    _expect_told(tester, None, State.PRE_OPERATIONAL)


@CONTROL.topic(HEARTBEATS)
def heartbeat_tells_operational(tester: Tester) -> None:
    """The heartbeat tells 05h in Operational."""
    _expect_told(tester, START, State.OPERATIONAL)


@CONTROL.topic(HEARTBEATS)
def heartbeat_tells_stopped(tester: Tester) -> None:
    """The heartbeat tells 04h in Stopped."""
    _expect_told(tester, STOP, State.STOPPED)


@CONTROL.topic(HEARTBEATS)
def heartbeat_ends_with_reset(tester: Tester) -> None:
    """A heartbeat that was not stored is as it was delivered after a reset of the communication."""
    tester.need_writable(PRODUCER)
    before = tester.number(PRODUCER)
    _need_producer(tester)
    tester.reset(RESET_COMMUNICATION)
    if (now := tester.number(PRODUCER)) != before:
        raise Failed(f"0x1017 is {now} instead of {before}")


def _watched(tester: Tester) -> int:
    """A node id that nobody has."""
    return 0x7E if tester.slave.node_id != 0x7E else 0x7D


def _watch(tester: Tester, subindex: int = 1, time: int = TIME) -> int:
    """Let the slave watch a node; its node id."""
    tester.need_writable(CONSUMER, subindex)
    node_id = _watched(tester)
    tester.write((CONSUMER, subindex), node_id << 16 | time)
    return node_id


@CONTROL.topic(CONSUMERS)
def consumer_is_set(tester: Tester) -> None:
    """0x1016 takes the node id and the time of a heartbeat that is watched."""
    node_id = _watch(tester)
    if (told := tester.number(CONSUMER, 1)) != node_id << 16 | TIME:
        raise Failed(f"0x1016:01 is {told:08X}h")


@CONTROL.topic(CONSUMERS)
def node_is_watched_once(tester: Tester) -> None:
    """A node that is watched already is refused: 06040043h."""
    tester.need_writable(CONSUMER, 2)
    node_id = _watch(tester)
    tester.expect_refusal((CONSUMER, 2), node_id << 16 | 2 * TIME, Abort.INCOMPATIBLE)


def _beat(tester: Tester, node_id: int, times: int = 5) -> None:
    for _ in range(times):
        tester.send(identifiers.heartbeat(node_id), bytes([STATE_BYTE[State.OPERATIONAL]]))
        for _frame in tester.listen(BEATS):
            pass


def _lost(tester: Tester, seconds: float = PATIENCE) -> bool:
    """Whether the slave tells that a heartbeat, or its guarding, has been lost."""
    emcy = identifiers.emcy(tester.slave.node_id)
    told = [frame.data for frame in tester.listen(seconds) if frame.can_id == emcy]
    return any(int.from_bytes(data[:2], "little") == HEARTBEAT_LOST for data in told)


@CONTROL.topic(HEARTBEATS)
def lost_heartbeat_is_told(tester: Tester) -> None:
    """A heartbeat that does not come in time is an error: EMCY 8130h."""
    node_id = _watch(tester)
    tester.nmt(START)
    _beat(tester, node_id)
    if not _lost(tester):
        raise Failed(f"no EMCY 8130h in {PATIENCE:g} s without heartbeat")


@CONTROL.topic(HEARTBEATS)
def heartbeat_in_time_is_no_error(tester: Tester) -> None:
    """No error while the heartbeat comes in time."""
    node_id = _watch(tester)
    tester.nmt(START)
    tester.forget()
    _beat(tester, node_id, 20)
    if _lost(tester, 0.0):
        raise Failed("EMCY 8130h though the heartbeat has come in time")


@CONTROL.topic(HEARTBEATS)
def watching_begins_with_first_heartbeat(tester: Tester) -> None:
    """A heartbeat that has never come is not missed."""
    _watch(tester)
    tester.nmt(START)
    if _lost(tester):
        raise Failed("EMCY 8130h before the first heartbeat")


@CONTROL.topic(CONSUMERS)
def nobody_is_watched_without_time(tester: Tester) -> None:
    """An entry of 0x1016 with a time of 0 watches nobody."""
    node_id = _watch(tester)
    tester.write((CONSUMER, 1), node_id << 16)
    tester.nmt(START)
    _beat(tester, node_id)
    if _lost(tester):
        raise Failed("EMCY 8130h of a node with a time of 0")


@CONTROL.topic(REACTIONS)
def lost_heartbeat_has_its_reaction(tester: Tester) -> None:
    """0x1029:01 says which state follows on a lost heartbeat: 0, 1 and 2."""
    tester.need_writable(REACTION, 1)
    tester.need_writable(CONSUMER, 1)
    follow = {0: State.PRE_OPERATIONAL, 1: State.OPERATIONAL, 2: State.STOPPED}
    for value, state in follow.items():
        tester.reset()
        tester.write((REACTION, 1), value)
        node_id, period = _watch(tester), tester.watch()
        tester.nmt(START)
        _beat(tester, node_id)
        _lost(tester)
        tester.expect_state(state, period)


def _need_guarding(tester: Tester) -> None:
    """Raises `NotApplicable` if there are no objects for it."""
    tester.need(GUARD_TIME)
    tester.need(LIFE_TIME)
    entry = tester.entry(PRODUCER)
    if entry is not None and entry.writable:
        tester.write((PRODUCER, 0), 0)


def _guard(tester: Tester) -> int:
    """What is answered to one request."""
    tester.forget()
    tester.send(tester.error_control, remote=True)
    return tester.hear(tester.error_control, length=1)[0]


@CONTROL.topic(GUARDING)
def guarding_is_answered(tester: Tester) -> None:
    """A node that is guarded tells its state, and the toggle bit alternates from 0 on."""
    _need_guarding(tester)
    tester.reset(RESET_COMMUNICATION)
    _need_guarding(tester)
    told = [_guard(tester) for _ in range(4)]
    if told != [0x7F, 0xFF, 0x7F, 0xFF]:
        raise Failed(f"{bytes(told).hex(' ')} instead of 7f ff 7f ff")


@CONTROL.topic(GUARDING)
def guarding_toggle_begins_anew(tester: Tester) -> None:
    """The toggle bit is 0 after a reset of the communication."""
    _need_guarding(tester)
    _guard(tester)
    tester.reset(RESET_COMMUNICATION)
    _need_guarding(tester)
    if (told := _guard(tester)) & TOGGLE:
        raise Failed(f"the first answer is {told:02X}h")


@CONTROL.topic(GUARDING)
def guarding_tells_every_state(tester: Tester) -> None:
    """A node that is guarded tells 05h in Operational and 04h in Stopped."""
    _need_guarding(tester)
    for command, state in ((START, State.OPERATIONAL), (STOP, State.STOPPED)):
        tester.nmt(command)
        if (told := _guard(tester) & ~TOGGLE) != STATE_BYTE[state]:
            raise Failed(f"{told:02X}h in {state.lower()}")


@CONTROL.topic(GUARDING)
def lost_guarding_is_told(tester: Tester) -> None:
    """A master that no longer guards in the life time is an error: EMCY 8130h."""
    _need_guarding(tester)
    tester.need_writable(GUARD_TIME)
    tester.need_writable(LIFE_TIME)
    tester.write((GUARD_TIME, 0), 100)
    tester.write((LIFE_TIME, 0), 2)
    tester.nmt(START)
    for _ in range(4):
        _guard(tester)
        if _lost(tester, 0.1):
            raise Failed("EMCY 8130h while it is guarded")
    if not _lost(tester):
        raise Failed(f"no EMCY 8130h in {PATIENCE:g} s without guarding")


@CONTROL.topic(GUARDING)
def heartbeat_takes_the_place_of_guarding(tester: Tester) -> None:
    """A node with a heartbeat does not answer to guarding."""
    _need_guarding(tester)
    tester.need_writable(PRODUCER)
    tester.write((PRODUCER, 0), 10_000)
    tester.forget()
    tester.send(tester.error_control, remote=True)
    tester.expect_silence(tester.error_control, "is answered, with a heartbeat of 10 s")


@CONTROL.topic(GUARDING)
def who_is_not_guarded_is_silent(tester: Tester) -> None:
    """A node without 0x100C does not answer to guarding."""
    if tester.entry(GUARD_TIME) is not None:
        raise NotApplicable("there is guarding", GUARD_TIME)
    entry = tester.entry(PRODUCER)
    if entry is not None and entry.writable:
        tester.write((PRODUCER, 0), 0)
    tester.forget()
    usual = tester.count(tester.error_control, SILENCE)
    tester.send(tester.error_control, remote=True)
    if tester.count(tester.error_control, SILENCE) > usual + 1 - bool(entry and entry.writable):
        raise Failed("guarding is answered")


GROUPS = (CONTROL,)
