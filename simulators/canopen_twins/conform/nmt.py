"""Topics about NMT: the states of a slave, and the ways from one to another."""

from canopen_twins.conform.pdo import expect_none, sent_ids
from canopen_twins.conform.tester import (
    ENTER_PRE_OPERATIONAL,
    RESET_COMMUNICATION,
    RESET_NODE,
    SILENCE,
    START,
    STOP,
    Failed,
    Tester,
)
from canopen_twins.conform.topic import Group
from canopen_twins.slave.service import State

STATES = Group(9, "NMT states", "states")
TRANSITIONS = Group(10, "NMT transitions", "nmt")

MACHINE = "CiA 301, 7.3.2.2"
NOBODY = 0x7F  # a node id other than that of the slave


@STATES.topic(MACHINE)
def initialisation(tester: Tester) -> None:
    """Initialisation ends with one boot-up message, and in Pre-operational."""
    tester.reset()
    if any(
        frame.can_id == tester.error_control and not any(frame.data)
        for frame in tester.listen(SILENCE)
    ):
        raise Failed("there is a second boot-up message")
    if not tester.is_answering():
        raise Failed("SDO is not answered after the boot-up message")


@STATES.topic(MACHINE)
def pre_operational(tester: Tester) -> None:
    """Pre-operational: the state is told, SDO is answered, no PDO is sent."""
    tester.expect_state(State.PRE_OPERATIONAL, tester.watch())
    if not tester.is_answering():
        raise Failed("SDO is not answered")
    expect_none(tester, sent_ids(tester), "in pre-operational")


@STATES.topic(MACHINE)
def operational(tester: Tester) -> None:
    """Operational: the state is told, SDO is answered."""
    period = tester.watch()
    tester.nmt(START)
    tester.expect_state(State.OPERATIONAL, period)
    if not tester.is_answering():
        raise Failed("SDO is not answered")


@STATES.topic(MACHINE)
def stopped(tester: Tester) -> None:
    """Stopped: the state is told, SDO is not answered, no PDO is sent."""
    period, can_ids = tester.watch(), sent_ids(tester)
    tester.nmt(START)
    tester.nmt(STOP)
    tester.expect_state(State.STOPPED, period)
    if tester.is_answering():
        raise Failed("SDO is answered")
    expect_none(tester, can_ids, "in stopped")


@TRANSITIONS.topic(MACHINE)
def resets(tester: Tester) -> None:
    """Reset node and reset communication act in every state, and end in Pre-operational."""
    for command in (RESET_NODE, RESET_COMMUNICATION):
        for before in (START, STOP, ENTER_PRE_OPERATIONAL):
            tester.nmt(before)
            tester.reset(command)
            if not tester.is_answering():
                raise Failed(f"SDO is not answered after {command:02X}h")


@TRANSITIONS.topic(MACHINE)
def enters_pre_operational(tester: Tester) -> None:
    """Enter Pre-operational acts in Operational and in Stopped."""
    period = tester.watch()
    for before in (START, STOP):
        tester.nmt(before)
        tester.nmt(ENTER_PRE_OPERATIONAL)
        tester.expect_state(State.PRE_OPERATIONAL, period)


@TRANSITIONS.topic(MACHINE)
def starts(tester: Tester) -> None:
    """Start remote node acts in Pre-operational and in Stopped."""
    period = tester.watch()
    for before in (ENTER_PRE_OPERATIONAL, STOP):
        tester.nmt(before)
        tester.nmt(START)
        tester.expect_state(State.OPERATIONAL, period)


@TRANSITIONS.topic(MACHINE)
def stops(tester: Tester) -> None:
    """Stop remote node acts in Pre-operational and in Operational, for this node alone."""
    period = tester.watch()
    for before in (ENTER_PRE_OPERATIONAL, START):
        tester.nmt(before)
        tester.send(0x000, bytes([STOP, NOBODY if tester.slave.node_id != NOBODY else 1]))
        if not tester.is_answering():
            raise Failed("it stops when another node is told to")
        tester.nmt(STOP)
        tester.expect_state(State.STOPPED, period)


GROUPS = (STATES, TRANSITIONS)
