"""What came of a scenario: an outcome for everything that was expected or went wrong."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple


class Kind(StrEnum):
    """How an expectation or a step ended, from good to bad."""

    PASS = "PASS"
    SKIP = "SKIP"
    """It was left out, because of an error before it or because it cannot be done here."""
    FAIL = "FAIL"
    """Something else came than was expected."""
    ERROR = "ERROR"
    """A step could not be carried out, so the run says nothing about who is tested."""


class Finding(NamedTuple):
    """What was decided, and why."""

    kind: Kind
    seen: str


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
    scene: str = ""
    """The last frames in words and how the node was then, for what did not pass."""


@dataclass(frozen=True)
class Verdict:
    """All outcomes, in the order of the file."""

    file: str
    outcomes: tuple[Outcome, ...]
    name: str = ""
    """Of the scenario."""
    seed: int = 1
    seconds: float = field(default=0.0, compare=False)
    """Of the scenario that have been played."""

    @property
    def kind(self) -> Kind:
        """The worst of all outcomes."""
        order = list(Kind)
        return max((outcome.kind for outcome in self.outcomes), key=order.index, default=Kind.PASS)

    @property
    def ok(self) -> bool:
        """Whether everything that was not left out has come as expected."""
        return self.kind in (Kind.PASS, Kind.SKIP)

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
        if outcome.scene:
            note = [f"note: {outcome.note}"] if outcome.note else []
            lines += [f"        {line}" for line in (*note, *outcome.scene.splitlines())]
        return lines
