"""The picture: node below node on one time axis, the same bytes for the same run."""

import warnings
from collections.abc import Iterator
from io import BytesIO
from textwrap import shorten
from typing import TYPE_CHECKING, NamedTuple, Protocol

import matplotlib as mpl
from matplotlib.figure import Figure

from canopen_twins.record.plot import look
from canopen_twins.record.plot.panels import (
    CurvePanel,
    Emergencies,
    Expectations,
    Faults,
    Legend,
    States,
)
from canopen_twins.record.plot.run import Run, View

if TYPE_CHECKING:
    from matplotlib.axes import Axes


LONGEST = 90  # letters of a title
UNDATED = {
    "svg": {"Creator": None, "Date": None, "Format": None, "Type": None},
    "png": {"Software": None},
}


class Panel(Protocol):
    """A strip of the picture that shares the time axis."""

    @property
    def height(self) -> float:
        """Inches."""

    def draw(self, axes: "Axes") -> None:
        """Into axes of this height."""


class Placed(NamedTuple):
    """A panel, and where it begins."""

    panel: Panel
    top: float
    """Inches from the top of the picture."""

    @property
    def bottom(self) -> float:
        """Inches from the top of the picture."""
        return self.top + self.panel.height


def picture(run: Run, suffix: str) -> bytes:
    """The content of a file, `svg` or `png`."""
    with mpl.rc_context(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph")  # a name may have letters of any kind
        mpl.rcdefaults()
        mpl.rcParams.update(look.STYLE)
        figure = drawn(run)
        dots = min(look.RESOLUTION, look.HIGHEST / figure.get_figheight())
        file = BytesIO()
        figure.savefig(file, format=suffix, dpi=dots, metadata=UNDATED[suffix])
    return file.getvalue()


def drawn(run: Run) -> Figure:
    """Everything in its place."""
    placed = list(_placed(run))
    figure = Figure(figsize=(look.WIDTH, placed[-1].bottom + look.BOTTOM))
    _write(figure, look.HEADING, shorten(_printable(run.heading), LONGEST), look.LARGE)
    _write_verdict(figure, run)
    for each in placed:
        axes = _axes(figure, each)
        axes.set_xlim(0, run.duration)
        last = each is placed[-1]
        axes.tick_params(bottom=last, labelbottom=last)
        each.panel.draw(axes)
    axes.set_xlabel("time [s]")
    return figure


def _placed(run: Run) -> Iterator[Placed]:
    """The verdict first, then every node."""
    top = look.TOP
    for panel in _panels(run):
        yield Placed(panel, top)
        top += panel.height + look.GAP


def _panels(run: Run) -> Iterator[Panel]:
    if run.outcomes:
        yield Expectations(run)
    for view in run.views:
        yield Heading(view)
        yield from (CurvePanel(run, view, strip) for strip in view.strips)
        if view.emergencies:
            yield Emergencies(run, view)
        if run.faults(view):
            yield Faults(run, view)
        states = States(run, view)
        yield Legend(run, states)
        yield states


class Heading:
    """The name of a node."""

    height = look.LANE

    def __init__(self, view: View) -> None:
        self.title = _printable(view.title)

    def draw(self, axes: "Axes") -> None:
        """Over the full width."""
        axes.set_axis_off()
        axes.text(
            (look.MARGIN - look.LEFT) / look.AXIS,
            0,
            self.title,
            size=look.MEDIUM,
            weight="bold",
            va="bottom",
            transform=axes.transAxes,
        )


def _axes(figure: Figure, placed: Placed) -> "Axes":
    height = figure.get_figheight()
    left, width = look.LEFT / look.WIDTH, look.AXIS / look.WIDTH
    bottom, tall = 1 - placed.bottom / height, placed.panel.height / height
    return figure.add_axes((left, bottom, width, tall))


def _write(figure: Figure, bottom: float, text: str, size: float, colour: str = look.INK) -> None:
    """A line of text, so many inches from the top."""
    y = 1 - bottom / figure.get_figheight()
    figure.text(look.MARGIN / look.WIDTH, y, text, size=size, color=colour, va="bottom")


def _write_verdict(figure: Figure, run: Run) -> None:
    """Its first line, in its colour."""
    if run.verdict is None:
        _write(figure, look.VERDICT, "no scenario", look.MEDIUM)
        return
    told = _printable(str(run.verdict).splitlines()[0])
    colour = look.PASSED if run.verdict.ok else look.FAILED
    _write(figure, look.VERDICT, told, look.MEDIUM, colour)


def _printable(text: str) -> str:
    return "".join(letter if letter.isprintable() else " " for letter in text)
