"""Colours and sizes of a picture; colours after Okabe and Ito, for every kind of eyes."""

from collections.abc import Mapping
from typing import Any

from canopen_twins.device.chart import Mood

ACTUAL, SET = "#0072B2", "#E69F00"
EMCY, FAULT, FAILED, PASSED = "#A8447F", "#F0E442", "#B00020", "#009E73"
EDGE_OF_FAULT = "#8F8400"
INK, PALE = "#222222", "#BBBBBB"
MOODS: Mapping[Mood, str] = {
    Mood.OFF: "#CCCCCC",
    Mood.WAITING: "#56B4E9",
    Mood.ACTIVE: "#009E73",
    Mood.WARNING: "#E69F00",
    Mood.ERROR: "#D55E00",
}
WRITING: Mapping[Mood, str] = {Mood.ACTIVE: "white", Mood.ERROR: "white"}
"""Colours of letters on a mood, where they are not of ink."""

WIDTH, LEFT, RIGHT = 12.0, 1.15, 1.55  # inches
TOP, BOTTOM = 0.8, 0.55
AXIS = WIDTH - LEFT - RIGHT
CURVE, LANE, HEADING, VERDICT, GAP = 1.15, 0.22, 0.36, 0.6, 0.1
LETTER = 0.068  # inches that a letter takes at most, on the average of a word
PAD, MARGIN = 0.08, 0.1
MOST_ROWS = 6  # of labels that would lie upon each other
SMALL, MEDIUM, LARGE = 8, 9, 13  # points
RESOLUTION = 150  # dots per inch
HIGHEST = 30_000  # dots; what programs still open

STYLE: Mapping[Any, Any] = {
    "axes.edgecolor": PALE,
    "axes.labelcolor": INK,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "font.family": ["DejaVu Sans"],
    "font.size": SMALL,
    "legend.fontsize": SMALL,
    "path.simplify": False,  # a spike is to be seen
    "svg.fonttype": "none",  # text that can be searched
    "svg.hashsalt": "canopen-twins",
    "text.color": INK,
    "text.parse_math": False,  # a name is not a formula
    "xtick.color": INK,
    "ytick.color": INK,
}


def width_of(text: str) -> float:
    """Inches that a text takes in small letters, with a little air around it."""
    return len(text) * LETTER + 2 * PAD
