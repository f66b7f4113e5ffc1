"""Where labels go on a time axis, so that none lies upon another."""

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

from simulators.plot.look import AXIS, MOST_ROWS, PAD, width_of


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
    width = width_of(text)
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
