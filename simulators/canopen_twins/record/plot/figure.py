"""The picture: node below node on one time axis, the same bytes for the same run."""

import warnings
from collections.abc import Iterator
from io import BytesIO
from itertools import accumulate
from textwrap import shorten
from typing import TypeAlias

import matplotlib as mpl
from matplotlib.figure import Figure

from canopen_twins.record.plot import look
from canopen_twins.record.plot.panels import (
    CurvePanel,
    Emergencies,
    Expectations,
    Faults,
    Heading,
    Lanes,
    Legend,
    States,
    printable,
)
from canopen_twins.record.plot.run import Run

Panel: TypeAlias = CurvePanel | Heading | Lanes

LONGEST = 90  # letters of a title
UNDATED = {
    "svg": {"Creator": None, "Date": None, "Format": None, "Type": None},
    "png": {"Software": None},
}


def picture(run: Run, suffix: str) -> bytes:
    """The content of a file, `svg` or `png`."""
    with mpl.rc_context(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph")  # a name may have letters of any kind
        mpl.rcdefaults()
        mpl.rcParams.update(look.STYLE)
        figure = _drawn(run)
        dots = min(look.RESOLUTION, look.HIGHEST / figure.get_figheight())
        file = BytesIO()
        figure.savefig(file, format=suffix, dpi=dots, metadata=UNDATED[suffix])
    return file.getvalue()


def _drawn(run: Run) -> Figure:
    panels = list(_panels(run))
    tops = list(accumulate((panel.height + look.GAP for panel in panels), initial=look.TOP))
    figure = Figure(figsize=(look.WIDTH, tops[-2] + panels[-1].height + look.BOTTOM))
    _write(figure, look.HEADING, shorten(printable(run.heading), LONGEST), look.LARGE)
    _write_verdict(figure, run)
    for panel, top in zip(panels, tops, strict=False):
        axes = figure.add_axes(_place(figure, top, panel.height))
        axes.set_xlim(0, run.duration)
        last = panel is panels[-1]
        axes.tick_params(bottom=last, labelbottom=last)
        panel.draw(axes)
    axes.set_xlabel("time [s]")
    return figure


def _panels(run: Run) -> Iterator[Panel]:
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


def _write_verdict(figure: Figure, run: Run) -> None:
    """Its first line, in its colour."""
    if run.verdict is None:
        _write(figure, look.VERDICT, "no scenario", look.MEDIUM)
        return
    told = printable(str(run.verdict).splitlines()[0])
    colour = look.PASSED if run.verdict.ok else look.FAILED
    _write(figure, look.VERDICT, told, look.MEDIUM, colour)
