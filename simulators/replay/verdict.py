"""What came of a scenario: an outcome for everything that was expected or went wrong."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, NamedTuple

from simulators.segment import Record


class Kind(StrEnum):
    """How an expectation or a step ended, from good to bad."""

    PASS = "PASS"
    FAIL = "FAIL"
    """Something else came than was expected."""
    ERROR = "ERROR"
    """A step could not be carried out, so the run says nothing about who is tested."""


class Finding(NamedTuple):
    """What was decided, and why."""

    kind: Kind
    seen: str


class Scene(NamedTuple):
    """How things stood at a moment."""

    state: str
    """NMT state of the node."""
    faults: Mapping[str, Mapping[str, Any]]
    """Active faults with their parameters."""
    report: Mapping[str, object]
    """What a look at the model shows."""
    frames: tuple[Record, ...]
    """The last frames on the bus, with the times of the scenario."""

    def __str__(self) -> str:
        faults = ", ".join(_call(*fault) for fault in self.faults.items()) or "none"
        report = ", ".join(f"{name} {value}" for name, value in self.report.items())
        told = [f"node {self.state}; faults: {faults}", *([report] if report else [])]
        return "\n".join([*told, *(f"{record}  {record.sender}" for record in self.frames)])


def _call(name: str, parameters: Mapping[str, Any]) -> str:
    return f"{name}({', '.join(f'{key}={value}' for key, value in parameters.items())})"


@dataclass(frozen=True)
class Outcome:
    """One expectation, or one step that could not be carried out."""

    kind: Kind
    time: float
    """Seconds of the scenario at which it was decided."""
    line: int
    """Of the file."""
    what: str
    seen: str
    note: str = ""
    scene: Scene | None = None
    """Only for what did not pass."""


@dataclass(frozen=True)
class Verdict:
    """All outcomes, in the order of the file."""

    file: str
    outcomes: tuple[Outcome, ...]

    @property
    def kind(self) -> Kind:
        """The worst of all outcomes."""
        order = list(Kind)
        return max((outcome.kind for outcome in self.outcomes), key=order.index, default=Kind.PASS)

    @property
    def ok(self) -> bool:
        """Whether everything has come as expected."""
        return self.kind is Kind.PASS

    def __str__(self) -> str:
        """A line for the whole, one for each outcome, and the scene of what did not pass."""
        counts = {kind: sum(kind is each.kind for each in self.outcomes) for kind in Kind}
        told = ", ".join(f"{count} {kind}" for kind, count in counts.items() if count)
        lines = [f"{self.file}: {self.kind} ({told or 'nothing was expected'})"]
        for outcome in self.outcomes:
            lines += self._lines(outcome)
        return "\n".join(lines)

    def _lines(self, outcome: Outcome) -> list[str]:
        head = f"  {outcome.kind:5} {outcome.time:12.6f} s  {self.file}:{outcome.line}: "
        lines = [f"{head}{outcome.what}: {outcome.seen}"]
        if outcome.scene is not None:
            note = [f"note: {outcome.note}"] if outcome.note else []
            lines += [f"        {line}" for line in (*note, *str(outcome.scene).splitlines())]
        return lines
