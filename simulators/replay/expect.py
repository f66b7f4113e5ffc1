"""Expectations: a frame comes, none comes, or a value is in the dictionary."""

from dataclasses import dataclass
from math import inf

from simulators.node import Node
from simulators.objects import Rejected
from simulators.replay.patterns import Pattern
from simulators.replay.scenario import Expectation
from simulators.replay.targets import Target
from simulators.replay.verdict import Finding, Kind
from simulators.wire import Frame

TOLD = 5  # frames in one line


@dataclass(frozen=True)
class Comes(Expectation):
    """The node sends what is meant."""

    what: Pattern

    def on_frame(self, frame: Frame, node: Node) -> Finding | None:
        """The first that fits decides."""
        fits = self.what.fits(frame, node)
        return Finding(Kind.PASS, self.what.tell(frame)) if fits else None

    def at_end(self, frames: list[Frame], node: Node) -> Finding:
        """Nothing has fitted: say what came instead."""
        kin = [self.what.tell(frame) for frame in frames if self.what.is_kin(frame, node)]
        return Finding(Kind.FAIL, f"only {', '.join(kin[-TOLD:])}" if kin else "none came")

    def __str__(self) -> str:
        return f"{self.what}{_within(self.within)}"


@dataclass(frozen=True)
class Never(Expectation):
    """The node sends nothing of what is meant."""

    what: Pattern

    def on_frame(self, frame: Frame, node: Node) -> Finding | None:
        """The first that fits decides."""
        fits = self.what.fits(frame, node)
        return Finding(Kind.FAIL, self.what.tell(frame)) if fits else None

    def at_end(self, frames: list[Frame], node: Node) -> Finding:
        """Nothing has fitted."""
        return Finding(Kind.PASS, "none came")

    def __str__(self) -> str:
        return f"no {self.what} for {self.within:g} s"


@dataclass(frozen=True)
class Range:
    """Values that are meant, both ends included."""

    low: float = -inf
    high: float = inf
    hexadecimal: bool = False
    """Whether values are told in hexadecimal."""

    def tell(self, value: object) -> str:
        """A value, as the file would have it."""
        return f"{value:#06x}" if self.hexadecimal and isinstance(value, int) else f"{value}"

    def __contains__(self, value: object) -> bool:
        return isinstance(value, (int, float)) and self.low <= value <= self.high

    def __str__(self) -> str:
        if self.low == self.high:
            return self.tell(self.low)
        told = f"{self.tell(self.low)}..{self.tell(self.high)}"
        return told.replace("-inf..", "at most ").replace("..inf", " or more")


@dataclass(frozen=True)
class Text:
    """The one text that is meant."""

    text: str

    def tell(self, value: object) -> str:
        """A value in quotes."""
        return repr(value)

    def __contains__(self, value: object) -> bool:
        return value == self.text

    def __str__(self) -> str:
        return repr(self.text)


@dataclass(frozen=True)
class Holds(Expectation):
    """Objects have values; the look at them leaves no trace on the bus nor in the device."""

    wanted: tuple[tuple[Target, Range | Text], ...]

    looks = True

    def on_look(self, node: Node) -> Finding | None:
        """The first moment at which all of them hold decides."""
        finding = self._look(node)
        return finding if finding.kind is Kind.PASS else None

    def at_end(self, frames: list[Frame], node: Node) -> Finding:
        """As it is now."""
        return self._look(node)

    def _look(self, node: Node) -> Finding:
        values = [(target, wanted, _value(node, target)) for target, wanted in self.wanted]
        kind = Kind.PASS if all(value in wanted for _, wanted, value in values) else Kind.FAIL
        told = ", ".join(f"{target} is {wanted.tell(value)}" for target, wanted, value in values)
        return Finding(kind, told)

    def __str__(self) -> str:
        told = ", ".join(f"{target} {wanted}" for target, wanted in self.wanted)
        return f"{told}{_within(self.within)}"


def _within(seconds: float) -> str:
    return f" within {seconds:g} s" if seconds else " at once"


def _value(node: Node, target: Target) -> object:
    """What is no value, a text in brackets."""
    if node.slave is None:
        return "(silent)"
    try:
        entry = node.slave.entry(*target.address)
        return entry.unpack(entry.read())
    except Rejected as refusal:
        return f"(refused: {refusal})"
