"""What a run tells as it happens, and its outcomes with the frames around what did not pass."""

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from canopen_twins.bus.clock import MICROSECONDS, Clock
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Record
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.report import SHOWN, device_report, last_frames
from canopen_twins.scenario.scenario import Step
from canopen_twins.scenario.verdict import Finding, Kind, Outcome

AFTERWARDS = 5  # frames
WITHOUT_SNAPSHOT = (Kind.PASS, Kind.SKIP)


class PlayerEvent(NamedTuple):
    """Something a player does that is not to be seen in the frames.

    The kinds and their fields: `step` (line, what), `inject` (fault, parameters), `clear` (fault),
    `state` (state), `outcome` (verdict, line, what, seen).
    """

    time: float
    """Seconds of the scenario."""
    node: str
    """Its name; empty if it is about none."""
    kind: str
    fields: Mapping[str, object]


class Snapshot:
    """The last frames before a moment, how the nodes are then, and the first frames after it.

    `reports` say how the nodes are, and why they answered as they did.
    """

    def __init__(
        self, before: str, nodes: Sequence[Node], time: float, reports: Sequence[str]
    ) -> None:
        self._nodes = nodes
        self._before = before
        self._state = "\n".join(reports)
        self._mark = f"{time:12.6f}  ---- here"
        self._after: list[Record] = []

    @property
    def complete(self) -> bool:
        """Whether as much has come after it as is shown."""
        return len(self._after) == AFTERWARDS

    def hear(self, record: Record) -> None:
        """Take a frame that has come after it."""
        self._after.append(record)

    def __str__(self) -> str:
        after = [self._mark, last_frames(self._after, self._nodes)] if self._after else []
        return "\n".join([self._before, *after, self._state])


class RunLog:
    """Knows when the scenario has begun, so that whatever it tells has the time of the scenario."""

    def __init__(self, nodes: Mapping[str, Node], clock: Clock) -> None:
        self.listeners: list[Callable[[PlayerEvent], None]] = []
        self._nodes = nodes
        self._clock = clock
        self._begin = clock.ticks
        self._recent: deque[tuple[int, Frame, str]] = deque(maxlen=SHOWN)
        self._told: tuple[int, str] | None = None  # a microsecond, and the frames before it
        self._open: list[Snapshot] = []
        self._decided: list[tuple[Outcome, Snapshot | None]] = []

    def begin(self) -> None:
        """The scenario begins now."""
        self._told = None
        self._begin = self._clock.ticks

    @property
    def now(self) -> float:
        """Seconds of the scenario."""
        return self._seconds(self._clock.ticks)

    def hear(self, frame: Frame, sender: str) -> None:
        """Take a frame."""
        tick = self._clock.ticks
        self._told = None
        self._recent.append((tick, frame, sender))
        if self._open:
            record = Record(self._seconds(tick), frame, sender)
            for snapshot in self._open:
                snapshot.hear(record)
            self._open = [snapshot for snapshot in self._open if not snapshot.complete]

    def tell(self, node: str, kind: str, **fields: object) -> None:
        """The player does something."""
        event = PlayerEvent(self.now, node, kind, fields)
        for listener in self.listeners:
            listener(event)

    def decide(self, step: Step, finding: Finding, tick: int | None = None) -> None:
        """Take a finding down: of a microsecond, of this one if none is given."""
        outcome = self._outcome(step, finding, tick)
        snapshot = None
        if finding.kind not in WITHOUT_SNAPSHOT:
            snapshot = self._snapshot(outcome.time, step)
            self._open.append(snapshot)
        self._decided.append((outcome, snapshot))
        fields = {"line": outcome.line, "what": outcome.what, "seen": outcome.seen}
        self.tell(step.node, "outcome", verdict=str(outcome.kind), **fields)

    @property
    def judged(self) -> bool:
        """Whether anything has been decided, beside what this bus cannot do."""
        return any(outcome.kind is not Kind.SKIP for outcome, _ in self._decided)

    def outcomes(self, undecided: Iterable[tuple[Step, Finding]]) -> tuple[Outcome, ...]:
        """All in the order of the file, with what is to be said now of what is not decided."""
        outcomes = [replace(each, scene=str(shown or "")) for each, shown in self._decided]
        for step, finding in undecided:
            outcome = self._outcome(step, finding)
            outcomes.append(replace(outcome, scene=str(self._snapshot(outcome.time, step))))
        return tuple(sorted(outcomes, key=lambda outcome: outcome.line))

    def _outcome(self, step: Step, finding: Finding, tick: int | None = None) -> Outcome:
        time, what = self.now if tick is None else self._seconds(tick), str(step.action)
        return Outcome(finding.kind, time, step.line, what, finding.seen, step.note, node=step.node)

    def _snapshot(self, time: float, step: Step) -> Snapshot:
        """Of this moment; what a step expects concerns its node."""
        records = [
            Record(self._seconds(tick), frame, sender) for tick, frame, sender in self._recent
        ]
        since, expected = self._begin / MICROSECONDS, step.action.expected
        reports = [
            device_report(node, records, since, expected if name == step.node else None)
            for name, node in self._nodes.items()
        ]
        return Snapshot(self._before(records), tuple(self._nodes.values()), time, reports)

    def _before(self, records: Sequence[Record]) -> str:
        """The same for all that is decided at one moment, as all that is left is at the end."""
        tick = self._clock.ticks
        if self._told is None or self._told[0] != tick:
            self._told = tick, last_frames(records, tuple(self._nodes.values()))
        return self._told[1]

    def _seconds(self, tick: int) -> float:
        return (tick - self._begin) / MICROSECONDS
