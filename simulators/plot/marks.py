"""What has a label at its moment: emergencies, faults, and what was expected."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from simulators.plot import look
from simulators.plot.lane import Lane
from simulators.plot.place import label, rows
from simulators.plot.run import Run, Span
from simulators.plot.view import View

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Marks(Lane):
    """Moments or times that have a label, in as many rows as that takes."""

    colour = look.INK

    def __init__(self, run: Run, name: str, told: Sequence[tuple[str, Span]]) -> None:
        super().__init__(run, [])
        self.told = told
        self.labels = [
            label(text, self.inches(span.start), self.inches(span.end)) for text, span in told
        ]
        self.rows = [min(row, look.MOST_ROWS) for row in rows(self.labels)]
        count = min(max(self.rows, default=0) + 1, look.MOST_ROWS)
        self.names = [name, *[""] * (count - 1)]

    def draw(self, axes: "Axes") -> None:
        """What finds no row is there without its label."""
        super().draw(axes)
        for (_, span), told, row in zip(self.told, self.labels, self.rows, strict=True):
            self.mark(axes, span, min(row, look.MOST_ROWS - 1))
            if row < look.MOST_ROWS:
                self.write(axes, told, row, self.colour)

    def mark(self, axes: "Axes", span: Span, row: int) -> None:
        """What the label belongs to."""
        raise NotImplementedError


class Emergencies(Marks):
    """A line for every EMCY, with its code."""

    colour = look.EMCY

    def __init__(self, run: Run, view: View) -> None:
        told = [(f"{each.code:04X}h", Span(each.time, each.time)) for each in view.emergencies]
        super().__init__(run, "EMCY", told)

    def mark(self, axes: "Axes", span: Span, row: int) -> None:
        """Below the line through the curves."""
        axes.vlines(span.start, row + 0.1, row + 0.9, color=self.colour, lw=1)


class Faults(Marks):
    """A bar for every fault, from the moment it is injected to the one when it is gone."""

    def __init__(self, run: Run, view: View) -> None:
        super().__init__(run, "faults", run.faults(view))

    def mark(self, axes: "Axes", span: Span, row: int) -> None:
        """The bar."""
        self.bars(axes, [span], row, look.FAULT)


class Expectations(Marks):
    """A dot for what came as expected, a cross and its line in the file for what did not."""

    colour = look.FAILED

    def __init__(self, run: Run) -> None:
        told = [
            (f"{each.kind} line {each.line}", Span(each.time, each.time)) for each in run.failed
        ]
        super().__init__(run, "expected", sorted(told, key=lambda each: each[1]))

    def draw(self, axes: "Axes") -> None:
        """The dots are in the first row."""
        times = [each.time for each in self.run.passed]
        axes.plot(times, [0.5] * len(times), "o", color=look.PASSED, ms=4, clip_on=False)
        super().draw(axes)

    def mark(self, axes: "Axes", span: Span, row: int) -> None:
        """The cross."""
        axes.plot([span.start], [row + 0.5], "x", color=self.colour, ms=6, mew=2, clip_on=False)
