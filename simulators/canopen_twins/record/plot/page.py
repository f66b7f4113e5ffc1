"""A page with the picture, the verdict, and what the picture has no room for."""

import re
from collections.abc import Iterable, Iterator, Sequence
from html import escape

from canopen_twins.record.plot.run import MOST_MARKS, Run
from canopen_twins.record.plot.track import Span

HEAD = """\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{title}</title>
<style>
body {{ font-family: sans-serif; color: #222; max-width: 75rem; margin: 1rem auto; }}
svg {{ max-width: 100%; height: auto; }}
table {{ border-collapse: collapse; }}
th, td {{ text-align: left; padding: 0.15rem 1rem 0.15rem 0; vertical-align: top; }}
td:first-child {{ text-align: right; font-variant-numeric: tabular-nums; }}
pre {{ overflow-x: auto; }}
</style>
</head>
<body>
<h1>{title}</h1>
"""

MOST_LINES = 2000
"""Of a verdict; the command prints all."""

Row = Sequence[str]


def page(run: Run, svg: str) -> str:
    """One file that needs no other and no network."""
    head = HEAD.format(title=escape(run.heading))
    picture = re.sub(r"^.*?(?=<svg)", "", svg, count=1, flags=re.DOTALL)  # no prologue within HTML
    parts = [f"<figure>\n{picture}</figure>\n", *_sections(run), "</body>\n</html>\n"]
    return head + "".join(parts)


def _sections(run: Run) -> Iterator[str]:
    if (verdict := run.verdict) is not None:
        lines = str(verdict).splitlines()
        more = [f"... and {len(lines) - MOST_LINES} lines more"] if len(lines) > MOST_LINES else []
        told = "\n".join([*lines[:MOST_LINES], *more])
        yield f"<h2>Verdict</h2>\n<pre>{escape(told)}</pre>\n"
    yield from _emergencies(run)
    yield from _faults(run)


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


def _end(run: Run, span: Span) -> str:
    return "the end" if span.end == run.duration else _seconds(span.end)


def _seconds(time: float) -> str:
    return f"{time:.6f}"


def _table(title: str, head: Row, rows: Iterable[Row]) -> str:
    lines = [_row("th", head), *(_row("td", row) for row in rows)]
    return f"<h2>{title}</h2>\n<table>\n{''.join(lines)}</table>\n"


def _row(tag: str, cells: Row) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>\n"
