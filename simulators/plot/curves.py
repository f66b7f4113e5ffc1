"""A curve with its set value, and behind it what happened meanwhile."""

import re
from math import floor, log10
from typing import TYPE_CHECKING

from simulators.plot import look
from simulators.plot.run import Run, joined
from simulators.plot.track import Points
from simulators.plot.view import Strip, View

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DIGITS = 4  # of an axis
AIR = 0.08  # of the height of an axis
BESIDE = -0.055  # of the axis: where the labels stand, one below the other


class CurvePanel:
    """One quantity of a node."""

    height = look.CURVE

    def __init__(self, run: Run, view: View, strip: Strip) -> None:
        self.run, self.view, self.strip = run, view, strip

    def draw(self, axes: "Axes") -> None:
        """Into axes of its height, over the time of the run."""
        curve, strip = self.strip.curve, self.strip
        axes.set_ylabel(f"{curve.label}\n[{curve.unit}]" if curve.unit else curve.label)
        axes.yaxis.set_label_coords(BESIDE, 0.5)
        axes.grid(color=look.PALE, lw=0.4)
        axes.locator_params(axis="y", nbins=5)
        self._events(axes)
        if strip.wanted is not None:
            self._line(axes, "set", strip.wanted.points, look.SET, "--")
        self._line(axes, "actual", strip.actual.points, look.ACTUAL, "-")
        axes.set_ylim(self._ends)
        axes.legend(
            loc="upper left", bbox_to_anchor=(1, 1), frameon=False, handlelength=1.5, reverse=True
        )

    @property
    def _ends(self) -> tuple[float, float]:
        """Of the axis: zero is on it, and there is air above and below."""
        tracks = [self.strip.actual, *([self.strip.wanted] if self.strip.wanted else [])]
        values = [point.value or 0.0 for track in tracks for point in track.points]
        low, high = min(0.0, *values), max(0.0, *values)
        if low == high:
            high = 1.0
        air = AIR * (high - low)
        return low - air, high + air

    def _line(
        self, axes: "Axes", name: str, points: Points[float | None], colour: str, style: str
    ) -> None:
        """In steps, as the value holds until the next; its last one is told."""
        times = [point.time for point in points] + [self.run.duration]
        values = [point.value for point in points] + [points[-1].value]
        numbers = [float("nan") if value is None else value for value in values]
        (line,) = axes.plot(times, numbers, color=colour, ls=style, lw=1.3, drawstyle="steps-post")
        line.set_label(f"{name} → {self._told(values[-1])}")
        line.set_gid(identifier(self.view.name, self.strip.curve.label, name))

    def _told(self, value: float | None) -> str:
        """As exactly as the axis can be read."""
        if value is None:
            return "none"
        low, high = self._ends
        digits = DIGITS - 1 - floor(log10(high - low))
        return f"{round(value, digits) + 0.0:g} {self.strip.curve.unit}".strip()  # never -0

    def _events(self, axes: "Axes") -> None:
        for span in joined(span for _, span in self.run.faults(self.view)):
            axes.axvspan(span.start, span.end, color=look.FAULT, alpha=0.25, lw=0)
        emergencies = [each.time for each in self.view.emergencies]
        failed = [each.time for each in self.run.failed]
        height = axes.get_xaxis_transform()
        axes.vlines(emergencies, 0, 1, color=look.EMCY, lw=0.8, ls=":", transform=height)
        axes.vlines(failed, 0, 1, color=look.FAILED, lw=1, transform=height)


def identifier(*words: str) -> str:
    """Of an element of the picture."""
    return re.sub(r"[^A-Za-z0-9.]+", "-", ".".join(words)).lower()
