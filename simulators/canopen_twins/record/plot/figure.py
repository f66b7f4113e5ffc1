"""The picture: panels one below the other on one time axis, the same bytes for the same run."""

import re
import warnings
from collections.abc import Iterable, Iterator, Sequence
from io import BytesIO
from itertools import accumulate
from math import floor, inf, log10
from textwrap import shorten
from typing import NamedTuple

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from canopen_twins.device.chart import Band
from canopen_twins.record.plot import look
from canopen_twins.record.plot.look import AXIS, MOST_ROWS, PAD
from canopen_twins.record.plot.run import CurveHistory, NodeHistory, Run
from canopen_twins.record.plot.track import Points, Span, Track, joined
from canopen_twins.scenario import Kind

LONGEST = 90  # letters of a title
UNDATED = {
    "svg": {"Creator": None, "Date": None, "Format": None, "Type": None},
    "png": {"Software": None},
}
AIR = 0.08  # of the height of an axis
BAR = 0.8  # of a row
BESIDE = -0.055  # of the axis: where the labels stand, one below the other
DIGITS = 4  # of an axis
EDGE = 0.6  # points
NARROWEST = 2 / 1000  # of the axis: what is shorter can still be seen
SWATCH = 0.15  # inches


def picture(run: Run, suffix: str, headed: bool = True) -> bytes:
    """The content of a file, `svg` or `png`; on a page the name and the verdict stand beside it."""
    with mpl.rc_context(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph")  # a name may have letters of any kind
        mpl.rcdefaults()
        mpl.rcParams.update(look.STYLE)
        figure = _drawn(run, headed)
        dots = min(look.RESOLUTION, look.HIGHEST / figure.get_figheight())
        file = BytesIO()
        figure.savefig(file, format=suffix, dpi=dots, metadata=UNDATED[suffix])
    return file.getvalue()


def _drawn(run: Run, headed: bool) -> Figure:
    panels = list(_panels(run))
    top = look.TOP if headed else look.GAP
    tops = list(accumulate((panel.height + look.GAP for panel in panels), initial=top))
    figure = Figure(figsize=(look.WIDTH, tops[-2] + panels[-1].height + look.BOTTOM))
    if headed:
        _head(figure, run)
    for panel, top in zip(panels, tops, strict=False):
        axes = figure.add_axes(_place(figure, top, panel.height))
        axes.set_xlim(0, run.duration)
        last = panel is panels[-1]
        axes.tick_params(bottom=last, labelbottom=last)
        panel.draw(axes)
    axes.set_xlabel("time [s]")
    return figure


def _head(figure: Figure, run: Run) -> None:
    _write(figure, look.HEADING, shorten(_printable(run.heading), LONGEST), look.LARGE)
    told, colour = "no scenario", look.INK
    if (verdict := run.verdict) is not None:
        told, colour = str(verdict).splitlines()[0], look.PASSED if verdict.ok else look.FAILED
    _write(figure, look.VERDICT, _printable(told), look.MEDIUM, colour)


def _panels(run: Run) -> "Iterator[CurvePanel | Heading | Lanes]":
    """The verdict first, then every node."""
    if run.outcomes:
        yield Expectations(run)
    for node in run.nodes:
        yield Heading(node)
        yield from (CurvePanel(run, node, curve) for curve in node.curves)
        if node.emergencies:
            yield Emergencies(run, node)
        if run.faults(node):
            yield Faults(run, node)
        states = States(run, node)
        yield Legend(run, states)
        yield states


def _place(figure: Figure, top: float, tall: float) -> tuple[float, float, float, float]:
    """In parts of the picture, of a panel that is so many inches tall and as far from its top."""
    height = figure.get_figheight()
    bottom = 1 - (top + tall) / height
    return look.LEFT / look.WIDTH, bottom, look.AXIS / look.WIDTH, tall / height


def _write(figure: Figure, bottom: float, text: str, size: float, colour: str = look.INK) -> None:
    """A line of text, so many inches from the top."""
    y = 1 - bottom / figure.get_figheight()
    figure.text(look.MARGIN / look.WIDTH, y, text, size=size, color=colour, va="bottom")


class Label(NamedTuple):
    """A text at a mark or a bar, all in inches of the axis."""

    text: str
    at: float
    """Where the text begins, or ends if it is `flipped`."""
    left: float
    right: float
    """What text and bar take together."""
    flipped: bool = False


def label(text: str, start: float, end: float) -> Label:
    """Within a bar if there is room, else to its right, else to its left; a mark has no width."""
    width = look.width_of(text)
    if end - start >= width:
        return Label(text, start + PAD, start, end)
    if end + width <= AXIS:
        return Label(text, end + PAD, start, end + width)
    return Label(text, start - PAD, start - width, end, flipped=True)


def rows(labels: Sequence[Label]) -> list[int]:
    """For each the first row in which there is room; `MOST_ROWS` if there is none."""
    taken = [-inf] * MOST_ROWS
    found = []
    for each in labels:
        row = next((row for row, right in enumerate(taken) if right <= each.left), MOST_ROWS)
        if row < MOST_ROWS:
            taken[row] = each.right
        found.append(row)
    return found


def _printable(text: str) -> str:
    """A text of one line that every font can write, or show that it cannot."""
    return "".join(letter if letter.isprintable() else " " for letter in text)


class Heading:
    """The name of a node."""

    height = look.LANE  # inches, as of every panel

    def __init__(self, node: NodeHistory) -> None:
        self._title = _printable(node.title)

    def draw(self, axes: Axes) -> None:
        """Over the full width."""
        axes.set_axis_off()
        left = (look.MARGIN - look.LEFT) / AXIS
        font = {"size": look.MEDIUM, "weight": "bold"}
        axes.text(left, 0, self._title, font, va="bottom", transform=axes.transAxes)


class CurvePanel:
    """One quantity of a node."""

    height = look.CURVE

    def __init__(self, run: Run, node: NodeHistory, curve: CurveHistory) -> None:
        self._run, self._node, self._curve = run, node, curve

    def draw(self, axes: Axes) -> None:
        """Into axes of its height, over the time of the run."""
        curve, history = self._curve.curve, self._curve
        axes.set_ylabel(f"{curve.label}\n[{curve.unit}]" if curve.unit else curve.label)
        axes.yaxis.set_label_coords(BESIDE, 0.5)
        axes.grid(color=look.PALE, lw=0.4)
        axes.locator_params(axis="y", nbins=5)
        self._mark(axes)
        if history.wanted is not None:
            self._line(axes, "set", history.wanted.points, look.SET, "--")
        self._line(axes, "actual", history.actual.points, look.ACTUAL, "-")
        axes.set_ylim(self._ends)
        axes.legend(
            loc="upper left", bbox_to_anchor=(1, 1), frameon=False, handlelength=1.5, reverse=True
        )

    @property
    def _ends(self) -> tuple[float, float]:
        """Of the axis: zero is on it, and there is air above and below."""
        tracks = [track for track in (self._curve.actual, self._curve.wanted) if track is not None]
        values = [point.value or 0.0 for track in tracks for point in track.points]
        low, high = min(0.0, *values), max(0.0, *values)
        if low == high:
            high = 1.0
        air = AIR * (high - low)
        return low - air, high + air

    def _line(
        self, axes: Axes, name: str, points: Points[float | None], colour: str, style: str
    ) -> None:
        """In steps, as the value holds until the next; its last one is told."""
        times = [point.time for point in points] + [self._run.duration]
        values = [point.value for point in points] + [points[-1].value]
        numbers = [float("nan") if value is None else value for value in values]
        (line,) = axes.plot(times, numbers, color=colour, ls=style, lw=1.3, drawstyle="steps-post")
        line.set_label(f"{name} → {self._told(values[-1])}")
        words = ".".join((self._node.name, self._curve.curve.label, name))
        line.set_gid(re.sub(r"[^A-Za-z0-9.]+", "-", words).lower())

    def _told(self, value: float | None) -> str:
        """As exactly as the axis can be read."""
        if value is None:
            return "none"
        low, high = self._ends
        digits = DIGITS - 1 - floor(log10(high - low))
        return f"{round(value, digits) + 0.0:g} {self._curve.curve.unit}".strip()  # never -0

    def _mark(self, axes: Axes) -> None:
        """What happened meanwhile."""
        for span in joined(span for _, span in self._run.faults(self._node)):
            axes.axvspan(span.start, span.end, color=look.FAULT, alpha=0.25, lw=0)
        emergencies = [each.time for each in self._node.emergencies]
        failed = [each.time for each in self._run.failed]
        height = axes.get_xaxis_transform()
        axes.vlines(emergencies, 0, 1, color=look.EMCY, lw=0.8, ls=":", transform=height)
        axes.vlines(failed, 0, 1, color=look.FAILED, lw=1, transform=height)


class Lanes:
    """Rows of bars, marks and labels; the first is at the top, each has a name on its left."""

    def __init__(self, run: Run, names: Sequence[str]) -> None:
        self.run = run
        self.names = names

    @property
    def height(self) -> float:
        """Inches."""
        return look.LANE * len(self.names)

    def draw(self, axes: Axes) -> None:
        """Into axes of its height, over the time of the run."""
        axes.set_ylim(len(self.names), 0)
        axes.set_yticks([row + 0.5 for row in range(len(self.names))], self.names)
        axes.tick_params(left=False)
        axes.spines["left"].set_visible(False)

    def inches(self, time: float) -> float:
        """Where a time is on the axis."""
        return AXIS * time / self.run.duration

    def seconds(self, inches: float) -> float:
        """The time at a place of the axis."""
        return self.run.duration * inches / AXIS

    def bars(self, axes: Axes, spans: Iterable[Span], row: int, colour: str, edge: str) -> None:
        """From when to when."""
        least = NARROWEST * self.run.duration
        widths = [(span.start, max(span.end - span.start, least)) for span in spans]
        place = (row + (1 - BAR) / 2, BAR)
        axes.broken_barh(widths, place, facecolor=colour, edgecolor=edge, lw=EDGE)

    def write(self, axes: Axes, told: Label, row: int, colour: str = look.INK) -> None:
        """A label where it has been placed."""
        side = "right" if told.flipped else "left"
        at = self.seconds(told.at), row + 0.5
        axes.text(*at, told.text, color=colour, ha=side, va="center_baseline")


class Marks(Lanes):
    """Moments or times that have a label, in as many rows as that takes."""

    colour = look.INK

    def __init__(self, run: Run, name: str, told: Sequence[tuple[str, Span]]) -> None:
        super().__init__(run, [])
        self.spans = [span for _, span in told]
        self.labels = [
            label(text, self.inches(span.start), self.inches(span.end)) for text, span in told
        ]
        self.rows = rows(self.labels)
        self.last = min(max(self.rows, default=0), MOST_ROWS - 1)
        self.names = [name, *[""] * self.last]

    def draw(self, axes: Axes) -> None:
        """What finds no row is marked in the last one, without its label."""
        super().draw(axes)
        for told, row in zip(self.labels, self.rows, strict=True):
            if row < MOST_ROWS:
                self.write(axes, told, row, self.colour)
        self.mark(axes, [min(row, self.last) for row in self.rows])

    def mark(self, axes: Axes, places: Sequence[int]) -> None:
        """What the labels belong to, each in its row."""
        raise NotImplementedError


class Emergencies(Marks):
    """A line for every EMCY, with its code."""

    colour = look.EMCY

    def __init__(self, run: Run, node: NodeHistory) -> None:
        told = [(f"{each.code:04X}h", Span(each.time, each.time)) for each in node.emergencies]
        super().__init__(run, "EMCY", told)

    def mark(self, axes: Axes, places: Sequence[int]) -> None:
        """Below the lines through the curves."""
        times = [span.start for span in self.spans]
        tops, ends = [row + 0.1 for row in places], [row + 0.9 for row in places]
        axes.vlines(times, tops, ends, color=self.colour, lw=1)


class Faults(Marks):
    """A bar for every fault, from the moment it is injected to the one when it is gone."""

    def __init__(self, run: Run, node: NodeHistory) -> None:
        super().__init__(run, "faults", run.faults(node))

    def mark(self, axes: Axes, places: Sequence[int]) -> None:
        """The bars."""
        for row in range(self.last + 1):
            spans = [span for span, place in zip(self.spans, places, strict=True) if place == row]
            self.bars(axes, spans, row, look.FAULT, look.EDGE_OF_FAULT)


class Expectations(Marks):
    """A dot for what came as expected, a cross and its line in the file for what did not."""

    colour = look.FAILED

    def __init__(self, run: Run) -> None:
        told = [
            (f"{each.kind} line {each.line}", Span(each.time, each.time)) for each in run.failed
        ]
        super().__init__(run, "expected", told)

    def mark(self, axes: Axes, places: Sequence[int]) -> None:
        """The crosses; the dots are in the first row, hollow for what was left out."""
        for kind, inside, edge in (
            (Kind.PASS, look.PASSED, look.PASSED),
            (Kind.SKIP, "white", look.INK),
        ):
            times = [each.time for each in self.run.outcomes if each.kind is kind]
            first = [0.5] * len(times)
            axes.plot(times, first, "o", mfc=inside, mec=edge, ms=4, clip_on=False)
        times = [span.start for span in self.spans]
        middles = [row + 0.5 for row in places]
        axes.plot(times, middles, "x", color=self.colour, ms=6, mew=2, clip_on=False)


class States(Lanes):
    """NMT state and, if the device tells it, its own."""

    def __init__(self, run: Run, node: NodeHistory) -> None:
        self.tracks = {"NMT": node.nmt}
        if node.state is not None:
            self.tracks["device"] = node.state
        super().__init__(run, list(self.tracks))

    def draw(self, axes: Axes) -> None:
        """Bars, with what they mean inside where there is room."""
        super().draw(axes)
        for row, track in enumerate(self.tracks.values()):
            self._draw_row(axes, row, track)

    def _draw_row(self, axes: Axes, row: int, track: Track[Band]) -> None:
        lasting = list(track.spans(self.run.duration))
        for mood, colour in look.MOODS.items():
            spans = [span for span, band in lasting if band.mood is mood]
            self.bars(axes, spans, row, colour, colour)
        for span, band in lasting:
            start, end = self.inches(span.start), self.inches(span.end)
            if end - start >= look.width_of(band.label):
                told = label(band.label, start, end)
                self.write(axes, told, row, look.WRITING.get(band.mood, look.INK))


class Legend(Lanes):
    """Each state that there was, once, by the colour it has in the bars."""

    def __init__(self, run: Run, states: States) -> None:
        found = [[point.value for point in track.points] for track in states.tracks.values()]
        bands = [band for each in found for band in sorted(each, key=lambda band: band.mood)]
        self.swatches = list(_flowing(dict.fromkeys(bands)))
        super().__init__(run, [""] * (self.swatches[-1].row + 1))

    def draw(self, axes: Axes) -> None:
        """In lines, as a text."""
        super().draw(axes)
        axes.set_axis_off()
        for row, left, band in self.swatches:
            right, colour = left + SWATCH, look.MOODS[band.mood]
            self.bars(axes, [Span(self.seconds(left), self.seconds(right))], row, colour, colour)
            self.write(axes, Label(band.label, right + PAD, left, right), row)


class Swatch(NamedTuple):
    """A state in the legend, so many inches from the left."""

    row: int
    left: float
    band: Band


def _flowing(bands: Iterable[Band]) -> Iterator[Swatch]:
    row, left = 0, 0.0
    for band in bands:
        width = SWATCH + look.width_of(band.label)
        if left + width > AXIS:
            row, left = row + 1, 0.0
        yield Swatch(row, left, band)
        left += width
