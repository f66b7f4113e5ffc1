"""What lies below the curves of a node: its states, emergencies and faults; and the verdict."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from matplotlib.patches import Patch

from simulators.chart import Band
from simulators.plot import look
from simulators.plot.place import Label, label, rows
from simulators.plot.run import Run, Span
from simulators.plot.track import Points
from simulators.plot.view import View

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BAR = 0.8  # of a row


class Lane:
    """Rows on the time axis, the first at the top, each with a name on its left."""

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

    def bar(self, axes: "Axes", span: Span, row: int, colour: str) -> None:
        """From when to when; a narrow one can still be seen."""
        width = max(span.end - span.start, self.run.duration / 1000)
        axes.broken_barh([(span.start, width)], (row + (1 - BAR) / 2, BAR), color=colour, lw=0)

    def write(self, axes: "Axes", told: Label, row: int, colour: str) -> None:
        """A label where it has been placed."""
        axes.text(
            told.at / look.AXIS * self.run.duration,
            row + 0.5,
            told.text,
            color=colour,
            ha="right" if told.flipped else "left",
            va="center_baseline",
        )


class States(Lane):
    """NMT state and, if the device tells it, its own."""

    def __init__(self, run: Run, view: View) -> None:
        self.bands = {"NMT": view.nmt.points}
        if view.state is not None:
            self.bands["device"] = view.state.points
        super().__init__(run, list(self.bands))

    def draw(self, axes: "Axes") -> None:
        """Bars, with what they mean inside where there is room."""
        super().draw(axes)
        for row, points in enumerate(self.bands.values()):
            self._draw_row(axes, row, points)

    def _draw_row(self, axes: "Axes", row: int, points: Points[Band]) -> None:
        for span, band in self.run.lasting(points):
            self.bar(axes, span, row, look.MOODS[band.mood])
            start, end = self.inches(span.start), self.inches(span.end)
            if end - start >= look.width_of(band.label):
                colour = look.WRITING.get(band.mood, look.INK)
                self.write(axes, label(band.label, start, end), row, colour)


class Legend(Lane):
    """What the colours of the states mean."""

    def __init__(self, run: Run, states: States) -> None:
        super().__init__(run, [""])
        found = [{point.value for point in points} for points in states.bands.values()]
        self.bands = [band for bands in found for band in sorted(bands, key=lambda band: band.mood)]

    def draw(self, axes: "Axes") -> None:
        """One line; each state by the colour it has above."""
        super().draw(axes)
        axes.set_axis_off()
        patches = [Patch(color=look.MOODS[band.mood], label=band.label) for band in self.bands]
        axes.legend(
            handles=patches,
            ncols=len(patches),
            loc="center left",
            frameon=False,
            borderaxespad=0,
            borderpad=0,
            handlelength=1,
            handletextpad=0.4,
            columnspacing=1.2,
        )


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
        """From the top, where the line through the curves ends."""
        axes.vlines(span.start, 0, row + 0.9, color=self.colour, lw=1)


class Faults(Marks):
    """A bar for every fault, from the moment it is injected to the one when it is gone."""

    def __init__(self, run: Run, view: View) -> None:
        super().__init__(run, "faults", run.faults(view))

    def mark(self, axes: "Axes", span: Span, row: int) -> None:
        """The bar."""
        self.bar(axes, span, row, look.FAULT)


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
