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
        self.spans = [span for _, span in told]
        self.labels = [
            label(text, self.inches(span.start), self.inches(span.end)) for text, span in told
        ]
        self.rows = rows(self.labels)
        self.last = min(max(self.rows, default=0), look.MOST_ROWS - 1)
        self.names = [name, *[""] * self.last]

    def draw(self, axes: "Axes") -> None:
        """What finds no row is marked in the last one, without its label."""
        super().draw(axes)
        for told, row in zip(self.labels, self.rows, strict=True):
            if row < look.MOST_ROWS:
                self.write(axes, told, row, self.colour)
        self.mark(axes, [min(row, self.last) for row in self.rows])

    def mark(self, axes: "Axes", places: Sequence[int]) -> None:
        """What the labels belong to, each in its row."""
        raise NotImplementedError


class Emergencies(Marks):
    """A line for every EMCY, with its code."""

    colour = look.EMCY

    def __init__(self, run: Run, view: View) -> None:
        told = [(f"{each.code:04X}h", _moment(each.time)) for each in view.emergencies]
        super().__init__(run, "EMCY", told)

    def mark(self, axes: "Axes", places: Sequence[int]) -> None:
        """Below the lines through the curves."""
        times = [span.start for span in self.spans]
        tops, ends = [row + 0.1 for row in places], [row + 0.9 for row in places]
        axes.vlines(times, tops, ends, color=self.colour, lw=1)


class Faults(Marks):
    """A bar for every fault, from the moment it is injected to the one when it is gone."""

    def __init__(self, run: Run, view: View) -> None:
        super().__init__(run, "faults", run.faults(view))

    def mark(self, axes: "Axes", places: Sequence[int]) -> None:
        """The bars."""
        for row in range(self.last + 1):
            spans = [span for span, place in zip(self.spans, places, strict=True) if place == row]
            self.bars(axes, spans, row, look.FAULT, look.EDGE_OF_FAULT)


class Expectations(Marks):
    """A dot for what came as expected, a cross and its line in the file for what did not."""

    colour = look.FAILED

    def __init__(self, run: Run) -> None:
        told = [(f"{each.kind} line {each.line}", _moment(each.time)) for each in run.failed]
        super().__init__(run, "expected", told)

    def mark(self, axes: "Axes", places: Sequence[int]) -> None:
        """The crosses; the dots are in the first row, hollow for what was left out."""
        for outcomes, inside, edge in (
            (self.run.passed, look.PASSED, look.PASSED),
            (self.run.skipped, "white", look.INK),
        ):
            times = [each.time for each in outcomes]
            first = [0.5] * len(times)
            axes.plot(times, first, "o", mfc=inside, mec=edge, ms=4, clip_on=False)
        times = [span.start for span in self.spans]
        middles = [row + 0.5 for row in places]
        axes.plot(times, middles, "x", color=self.colour, ms=6, mew=2, clip_on=False)


def _moment(time: float) -> Span:
    return Span(time, time)
