"""Rows on the time axis, below the curves of a node."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from simulators.plot import look
from simulators.plot.place import Label
from simulators.plot.run import Run, Span

if TYPE_CHECKING:
    from matplotlib.axes import Axes

EDGE = 0.6  # points
BAR = 0.8  # of a row
NARROWEST = 2 / 1000  # of the axis: what is shorter can still be seen


class Lane:
    """The first row is at the top; each has a name on its left."""

    def __init__(self, run: Run, names: Sequence[str]) -> None:
        self.run = run
        self.names = names

    @property
    def height(self) -> float:
        """Inches."""
        return look.LANE * len(self.names)

    def draw(self, axes: "Axes") -> None:
        """Into axes of its height, over the time of the run."""
        axes.set_ylim(len(self.names), 0)
        axes.set_yticks([row + 0.5 for row in range(len(self.names))], self.names)
        axes.tick_params(left=False)
        axes.spines["left"].set_visible(False)

    def inches(self, time: float) -> float:
        """Where a time is on the axis."""
        return look.AXIS * time / self.run.duration

    def seconds(self, inches: float) -> float:
        """The time at a place of the axis."""
        return self.run.duration * inches / look.AXIS

    def bars(
        self, axes: "Axes", spans: Iterable[Span], row: int, colour: str, edge: str = ""
    ) -> None:
        """From when to when."""
        least = NARROWEST * self.run.duration
        widths = [(span.start, max(span.end - span.start, least)) for span in spans]
        place = (row + (1 - BAR) / 2, BAR)
        axes.broken_barh(widths, place, facecolor=colour, edgecolor=edge or colour, lw=EDGE)

    def write(self, axes: "Axes", told: Label, row: int, colour: str = look.INK) -> None:
        """A label where it has been placed."""
        axes.text(
            self.seconds(told.at),
            row + 0.5,
            told.text,
            color=colour,
            ha="right" if told.flipped else "left",
            va="center_baseline",
        )
