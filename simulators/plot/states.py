"""The states of a node as coloured bars, and what the colours mean."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, NamedTuple

from simulators.chart import Band
from simulators.plot import look
from simulators.plot.lane import Lane
from simulators.plot.place import Label, label
from simulators.plot.run import Run, Span
from simulators.plot.track import Points
from simulators.plot.view import View

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SWATCH = 0.15  # inches


class States(Lane):
    """NMT state and, if the device tells it, its own."""

    def __init__(self, run: Run, view: View) -> None:
        self.tracks = {"NMT": view.nmt.points}
        if view.state is not None:
            self.tracks["device"] = view.state.points
        super().__init__(run, list(self.tracks))

    def draw(self, axes: "Axes") -> None:
        """Bars, with what they mean inside where there is room."""
        super().draw(axes)
        for row, points in enumerate(self.tracks.values()):
            self._draw_row(axes, row, points)

    def _draw_row(self, axes: "Axes", row: int, points: Points[Band]) -> None:
        lasting = list(self.run.lasting(points))
        for mood, colour in look.MOODS.items():
            spans = [span for span, band in lasting if band.mood is mood]
            self.bars(axes, spans, row, colour)
        for span, band in lasting:
            start, end = self.inches(span.start), self.inches(span.end)
            if end - start >= look.width_of(band.label):
                told = label(band.label, start, end)
                self.write(axes, told, row, look.WRITING.get(band.mood, look.INK))


class Entry(NamedTuple):
    """A state in the legend, so many inches from the left."""

    row: int
    left: float
    band: Band


class Legend(Lane):
    """Each state that there was, once, by the colour it has in the bars."""

    def __init__(self, run: Run, states: States) -> None:
        found = [[point.value for point in points] for points in states.tracks.values()]
        bands = [band for each in found for band in sorted(each, key=lambda band: band.mood)]
        self.entries = list(_flowing(dict.fromkeys(bands)))
        super().__init__(run, [""] * (self.entries[-1].row + 1))

    def draw(self, axes: "Axes") -> None:
        """In lines, as a text."""
        super().draw(axes)
        axes.set_axis_off()
        for row, left, band in self.entries:
            right = left + SWATCH
            swatch = Span(self.seconds(left), self.seconds(right))
            self.bars(axes, [swatch], row, look.MOODS[band.mood])
            self.write(axes, Label(band.label, right + look.PAD, left, right), row)


def _flowing(bands: Iterable[Band]) -> Iterator[Entry]:
    row, left = 0, 0.0
    for band in bands:
        width = SWATCH + look.width_of(band.label)
        if left + width > look.AXIS:
            row, left = row + 1, 0.0
        yield Entry(row, left, band)
        left += width
