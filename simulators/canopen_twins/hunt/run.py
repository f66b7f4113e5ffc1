"""One run of a contract: what it was like, whether it failed, and how failures are told apart."""

from __future__ import annotations

import io
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, replace
from hashlib import sha256
from itertools import zip_longest

from canopen_twins.bus import sdo
from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import Cob, Identifier, classify, sdo_answer
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.waits import Wait, WaitRecorder
from canopen_twins.hunt.workers import Death, watched
from canopen_twins.scenario import Kind, Outcome, Player, Scenario, Verdict, play
from canopen_twins.scenario.player import LEFT_BEHIND
from canopen_twins.scenario.run_log import PlayerEvent
from canopen_twins.scenario.step_sequence import NEVER_CAME, UNDECIDED
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.service import State


@dataclass(frozen=True)
class Failure:
    """What did not come as expected; two that are equal are one find.

    There are no times, values and plans in it.
    """

    what: str
    """The expectation, or the master."""
    node: str
    state: str
    """Of the node when it was decided."""
    place: str = ""
    """The innermost line of the files of a master that has raised something."""


@dataclass(frozen=True)
class Cell:
    """Where in the conversation something went wrong."""

    fault: str
    phase: str


@dataclass(frozen=True)
class Result:
    """What came of a run; plain data, so that it can come from another process."""

    plan: Plan
    failures: tuple[Failure, ...] = ()
    error: str = ""
    """Why it says nothing about the master; empty if it does."""
    trace: str = ""
    """A digest of all frames with their times, identifiers, data and senders."""
    seconds: float = 0.0
    """Simulated."""
    cells: tuple[Cell, ...] = ()
    """In the order of time."""
    fired: int = 0
    """How many of the disturbances have come."""
    waits: tuple[Wait, ...] = ()
    """What the master has done for want of an answer."""
    verdict: Verdict | None = None
    """With the words; for those that have failed."""
    whereabouts: tuple[str, ...] = ()
    """In which lines the master was at each of the failures."""
    frames: tuple[str, ...] = ()
    """All of them, for who wants to compare: microsecond, frame and sender."""
    left_behind: bool = False
    """Whether the master has left processes behind."""
    death: Death | None = None
    """How it has ended the process that played it, if it has."""


VACUOUS = (NEVER_CAME.seen, UNDECIDED.seen)
"""What says nothing of a master that something has kept from getting there."""
NOT_REACHED = "not reached"
ENDED = "has ended its process"
MASTER, COMMAND = "master ", "the command "
"""What a master is called in a verdict: a function, or another process."""


def run(contract: Contract, plan: Plan) -> Result:
    """Play a contract with a plan: the same gives the same, in whatever process."""
    return replace(run_to_compare(contract, plan), frames=())


def run_to_compare(contract: Contract, plan: Plan) -> Result:
    """The same, with its frames."""
    try:
        scenario = contract.scenario(plan)
    except UserError as refusal:
        return Result(plan, error=str(refusal))
    observer = Observer()
    verdict = judged(contract, scenario, observer.attach)
    errors = [each for each in verdict.outcomes if each.kind is Kind.ERROR and not _is_void(each)]
    failed = {} if errors else observer.failures
    return Result(
        plan,
        tuple(failed),
        f"{errors[0].what}: {errors[0].seen}" if errors else "",
        sha256("".join(observer.frames).encode()).hexdigest(),
        verdict.seconds,
        tuple(observer.cells),
        observer.fired,
        observer.waits,
        verdict if failed else None,
        tuple(failed.values()),
        tuple(observer.frames),
        any(each.seen.startswith(LEFT_BEHIND) for each in verdict.outcomes),
    )


def ended(contract: Contract, plan: Plan, death: Death) -> Result:
    """What came of a run that has ended every process it was given to."""
    if contract.command:
        return Result(plan, error=f"the process of the twins has ended: {death.words}")
    scenario = contract.scenario(plan)
    assert scenario.master is not None
    what = f"{MASTER}{scenario.master.name}"
    seen = f"{ENDED}: {death.words}{f' in {death.place}' if death.place else ''}"
    outcome = Outcome(Kind.FAIL, 0.0, scenario.master_line, what, seen)
    verdict = Verdict(str(scenario.file), (outcome,), scenario.name, scenario.seed)
    failure = Failure(f"{what}: {death.words}", "", "", death.place)
    return Result(plan, (failure,), verdict=verdict, whereabouts=("",), death=death)


def difference(one: Result, other: Result) -> str:
    """The first frame in which two runs differ, in words; empty if there is none."""
    if other.error:
        return other.error
    for here, there in zip_longest(one.frames, other.frames):
        if here != there:
            return f"{_told(here)}; {_told(there)}"
    if one.failures != other.failures:
        return "the same frames, and another outcome"
    return ""


def _told(line: str | None) -> str:
    if line is None:
        return "nothing more"
    tick, frame, sender = line.rstrip("\n").split(" ", 2)
    return f"{frame} of {sender or 'the scenario'} at {int(tick) / MICROSECONDS:.6f} s"


def _is_void(outcome: Outcome) -> bool:
    """Whether an error is none of the contract: it has not come to something, or was ended."""
    is_vacuous = outcome.seen in VACUOUS or NOT_REACHED in outcome.seen
    return is_vacuous or outcome.what.startswith(COMMAND)


def _is_failure(event: PlayerEvent) -> bool:
    return event.fields["verdict"] == Kind.FAIL or str(event.fields["what"]).startswith(COMMAND)


def judged(
    contract: Contract, scenario: Scenario, observer: Callable[[Segment[Node], Player], None]
) -> Verdict:
    """The verdict of one run, in simulated time or beside the command of the contract."""
    with quiet(), watched():
        if not contract.command:
            return play(scenario, observers=[observer])
        # few hunts have one
        from canopen_twins.hunt.real_time import play_beside  # noqa: PLC0415

        return play_beside(scenario, contract.command, contract.hub, [observer])


@contextmanager
def quiet() -> Iterator[None]:
    """What a master prints and logs, thousands of times, is for nobody."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            yield
    finally:
        logging.disable(before)


class Observer:
    """Hears a run: its frames, where faults have struck, and how it was when something failed."""

    def __init__(self) -> None:
        self.frames: list[str] = []
        self.cells: list[Cell] = []
        self.failures: dict[Failure, str] = {}
        """With the lines in which the master was."""
        self._segment: Segment[Node]
        self._player: Player
        self._nodes: dict[str, Node] = {}
        self._phase = ""
        self._recorder = WaitRecorder()
        self._asked: dict[int, str] = {}  # what each node owes an answer to, by its identifier
        self._last: dict[int, str] = {}  # what the master has asked it for last

    @property
    def fired(self) -> int:
        """How many disturbances have come."""
        return len(self._player.fired)

    @property
    def waits(self) -> tuple[Wait, ...]:
        """What the master has done for want of an answer."""
        return self._recorder.waits

    def attach(self, segment: Segment[Node], player: Player) -> None:
        """Hear everything from now on."""
        self._segment, self._player = segment, player
        self._nodes = {node.wire.name: node for node in segment.nodes}
        segment.listeners.append(self._hear)
        player.listeners.append(self._follow)

    def _hear(self, frame: Frame, sender: str) -> None:
        tick = self._segment.clock.ticks
        self.frames.append(f"{tick} {frame} {sender}\n")
        if len(frame.data) == sdo.LENGTH and not frame.extended:
            if sender in self._nodes:
                self._asked.pop(frame.can_id, None)
                if sdo.is_answer(frame, self._nodes[sender].node_id):
                    self._recorder.answer(sender, frame.data, tick)
                return
            if (told := _access(frame)) is not None:
                self._last[frame.can_id - 0x80] = self._asked[frame.can_id - 0x80] = told
            for name, node in self._nodes.items():
                if sdo.is_request(frame, node.node_id):
                    self._recorder.ask(name, frame.data, tick)

    def _follow(self, event: PlayerEvent) -> None:
        if event.kind == "step" and event.node:  # it is told before it is carried out
            self._phase = self._phase_of(self._nodes[event.node])
        elif event.kind == "inject":
            self.cells.append(Cell(str(event.fields["fault"]), self._phase))
        elif event.kind == "outcome" and _is_failure(event) and not self._follows(event):
            self.failures.setdefault(self._failure(event), self._player.whereabouts())

    def _follows(self, event: PlayerEvent) -> bool:
        """Whether it has failed for want of a master, which has ended before."""
        is_master = str(event.fields["what"]).startswith(MASTER)
        return self._player.ended is not None and not is_master

    def _phase_of(self, node: Node) -> str:
        """Of the conversation: the state of a node, and what it has been asked for last."""
        if node.state is State.INITIALISING:
            return "silent"
        state = str(node.state).lower() + (", error" if node.device.emergencies else "")
        answer = sdo_answer(node.node_id)
        if answer in self._asked:
            return f"{state}, asked to {self._asked[answer]}"
        return f"{state}, after {self._last[answer]}" if answer in self._last else state

    def _failure(self, event: PlayerEvent) -> Failure:
        what = str(event.fields["what"])
        if what.startswith(COMMAND):
            return Failure(f"{what} {event.fields['seen']}", "", "")
        ended = self._player.ended
        if what.startswith(MASTER) and ended is not None:
            kind = ended.words.partition(":")[0].partition(", at ")[0]
            return Failure(f"{what}: {kind}", "", "", ended.place)
        node = self._nodes.get(event.node)
        return Failure(what, event.node, "" if node is None else str(node.state).lower())


def _access(frame: Frame) -> str | None:
    """What a request of the master begins, in words."""
    asks = ACCESSES.get(sdo.specifier(frame.data))
    if classify(frame.can_id) != Identifier(Cob.SDO_REQUEST, frame.can_id & 0x7F) or asks is None:
        return None
    return f"{asks} {address_text(sdo.address(frame.data))}"


ACCESSES = {sdo.Ccs.UPLOAD: "read", sdo.Ccs.DOWNLOAD: "write"}
