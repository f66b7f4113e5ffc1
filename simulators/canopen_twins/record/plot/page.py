"""A page with the picture, the verdict, and what the picture has no room for."""

import re
from collections.abc import Iterable, Iterator, Sequence
from html import escape

from canopen_twins.record.plot.run import MOST_FRAMES, MOST_MARKS, Run
from canopen_twins.record.plot.track import Span

HEAD = """\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{title}</title>
<style>
body {{ font-family: sans-serif; color: #222; max-width: 75rem; margin: 1rem auto; }}
body {{ padding: 0 1rem; }}
figure {{ margin: 0; overflow: hidden; }}
svg {{ max-width: 100%; height: auto; touch-action: pan-y; }}
table {{ border-collapse: collapse; }}
th, td {{ text-align: left; padding: 0.15rem 1rem 0.15rem 0; vertical-align: top; }}
td:first-child {{ text-align: right; font-variant-numeric: tabular-nums; }}
pre {{ white-space: pre-wrap; overflow-wrap: anywhere; }}
pre span {{ display: block; padding-left: 9ch; text-indent: -9ch; }}
code {{ white-space: nowrap; }}
</style>
</head>
<body>
<h1>{title}</h1>
"""

ZOOM = """\
<script>
const svg = document.querySelector("figure svg"), whole = svg.viewBox.baseVal;
const full = {x: whole.x, y: whole.y, width: whole.width, height: whole.height};
let held = null;
function place(x, width) {
  width = Math.min(width, full.width);
  x = Math.max(full.x, Math.min(x, full.x + full.width - width));
  const height = full.height * width / full.width;
  const y = Math.max(full.y, Math.min(whole.y + (whole.height - height) / 2,
    full.y + full.height - height));
  svg.setAttribute("viewBox", [x, y, width, height].join(" "));
}
function zoom(factor, share) {
  const width = Math.min(full.width, Math.max(full.width / 50, whole.width * factor));
  place(whole.x + share * (whole.width - width), width);
}
svg.addEventListener("wheel", event => {
  if (!event.ctrlKey) return;
  event.preventDefault();
  zoom(Math.exp(event.deltaY / 300), event.offsetX / svg.clientWidth);
}, {passive: false});
svg.addEventListener("pointerdown", event => held = event.clientX);
window.addEventListener("pointerup", () => held = null);
svg.addEventListener("pointermove", event => {
  if (held === null) return;
  place(whole.x - (event.clientX - held) * whole.width / svg.clientWidth, whole.width);
  held = event.clientX;
});
svg.addEventListener("dblclick", event => zoom(0.5, event.offsetX / svg.clientWidth));
document.addEventListener("keydown", event => {
  const keys = {"+": () => zoom(0.7, 0.5), "-": () => zoom(1 / 0.7, 0.5),
    "0": () => place(full.x, full.width),
    ArrowLeft: () => place(whole.x - whole.width / 10, whole.width),
    ArrowRight: () => place(whole.x + whole.width / 10, whole.width)};
  if (event.key in keys) keys[event.key]();
});
</script>
"""
HINT = "Zoom: Ctrl and the wheel, double click, or the keys + - 0; move: drag, or the arrows."
MOST_LINES = 2000
"""Of a verdict; the command prints all."""

MASTER = "master"
"""Whoever is no node of the file."""

Row = Sequence[str]


def page(run: Run, svg: str) -> str:
    """One file that needs no other and no network."""
    head = HEAD.format(title=escape(run.heading))
    picture = re.sub(r"^.*?(?=<svg)", "", svg, count=1, flags=re.DOTALL)  # no prologue within HTML
    parts = [f"<figure>\n{picture}</figure>\n<p>{HINT}</p>\n", *_sections(run)]
    return head + "".join([*parts, ZOOM, "</body>\n</html>\n"])


def _sections(run: Run) -> Iterator[str]:
    if (verdict := run.verdict) is not None:
        lines = str(verdict).splitlines()
        more = [f"... and {len(lines) - MOST_LINES} lines more"] if len(lines) > MOST_LINES else []
        told = "".join(f"<span>{escape(line)}\n</span>" for line in [*lines[:MOST_LINES], *more])
        yield f"<h2>Verdict</h2>\n<pre>{told}</pre>\n"
    else:
        yield "<p>no scenario</p>\n"
    yield from _emergencies(run)
    yield from _faults(run)
    yield from _frames(run)


def _emergencies(run: Run) -> Iterator[str]:
    told = sorted((e.time, node.name, e.words) for node in run.nodes for e in node.emergencies)
    if told:
        rows = [(_seconds(time), name, words) for time, name, words in told]
        yield _table("Emergencies", ("at [s]", "node", "message"), rows)
    for node in run.nodes:
        if node.untold:
            words = f"{node.untold} more after the first {MOST_MARKS}"
            yield f"<p>{escape(node.name)}: {words}.</p>\n"


def _faults(run: Run) -> Iterator[str]:
    told = sorted((span, node.name, name) for node in run.nodes for name, span in run.faults(node))
    if told:
        rows = [(_seconds(span.start), _end(run, span), node, fault) for span, node, fault in told]
        yield _table("Faults", ("from [s]", "to [s]", "node", "fault"), rows)


def _frames(run: Run) -> Iterator[str]:
    if not run.frames:
        return
    rows = [
        (_seconds(told.time), told.sender or MASTER, str(told.frame), told.words)
        for told in run.frames
    ]
    yield _table("Frames", ("at [s]", "from", "frame", "in words"), rows)
    if run.unheard:
        yield f"<p>{run.unheard} more after the first {MOST_FRAMES}.</p>\n"


def _end(run: Run, span: Span) -> str:
    return "the end" if span.end == run.duration else _seconds(span.end)


def _seconds(time: float) -> str:
    return f"{time:.6f}"


def _table(title: str, head: Row, rows: Iterable[Row]) -> str:
    lines = [_row("th", head), *(_row("td", row) for row in rows)]
    return f"<h2>{title}</h2>\n<table>\n{''.join(lines)}</table>\n"


def _row(tag: str, cells: Row) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>\n"
