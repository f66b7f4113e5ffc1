"""What the master and the nodes should do, or should not: a sign and the window it is seen in."""

from collections.abc import Sequence
from dataclasses import dataclass

from canopen_twins.scenario.context import Context
from canopen_twins.scenario.matchers import Sign
from canopen_twins.scenario.scenario import Action, Condition
from canopen_twins.slave.object import Address


@dataclass(frozen=True)
class Expectation(Action):
    """A sign that is seen in a window that opens with the step.

    Whatever happens at that microsecond counts, before the step's turn or after, but not what set
    the step off; so does what happens at the last one. A look at the dictionary shows it as it is
    when a microsecond is over.
    """

    sign: Sign
    within: float | None = None
    """Seconds; None: until `before` or the end of the run, for a value that is wanted: at once."""
    before: Condition | None = None
    """What ends the window, too."""
    never: bool = False
    """Whether it must not be seen."""

    @property
    def about(self) -> Sequence[Address]:
        """The objects of its sign."""
        return self.sign.addresses

    @property
    def seconds(self) -> float | None:
        """How long the window is open at most; None: to the end of the run."""
        at_once = self.within is None and self.before is None and not self.never
        return 0.0 if at_once else self.within

    def carry_out(self, context: Context) -> None:
        """Watch from now on."""
        context.watch_for(self)

    def __str__(self) -> str:
        before = f" before {self.before}" if self.before else ""
        if self.never:
            return f"no {self.sign}{before}{_told(self.within, 'for')}"
        within = _told(self.seconds, "within") if self.seconds != 0 else " at once"
        return f"{self.sign}{within}{before}"


def _told(seconds: float | None, preposition: str) -> str:
    return "" if seconds is None else f" {preposition} {seconds:g} s"
