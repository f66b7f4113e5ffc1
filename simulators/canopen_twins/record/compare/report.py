"""What a comparison has found: in words, as JSON, and as a page."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from html import escape

from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.record.compare.agreement import Account, Agreement, Difference, Row, Subject

VERSION = 1


def text(agreement: Agreement) -> str:
    """For people: what agrees how far, then each difference with its frames."""
    parts = (_head, _rows, _differences, _unexercised)
    return "\n".join(line for part in parts for line in part(agreement))


def summary(agreement: Agreement) -> str:
    """The same without the differences, which have been told."""
    parts = (_head, _rows, _unexercised)
    return "\n".join(line for part in parts for line in part(agreement))


def _head(agreement: Agreement) -> Iterator[str]:
    yield from agreement.remarks
    told = f"{agreement.agreed} of {agreement.total} agree"
    yield f"{percent(agreement.share)}: {told}"


def percent(share: float) -> str:
    """100 % only for all of them."""
    return "100 %" if share == 1 else f"{min(100 * share, 99.99):.2f} %"


def _rows(agreement: Agreement) -> Iterator[str]:
    several = len({subject.node for subject in agreement.rows}) > 1
    rows = list(agreement.rows.items())
    names = [f"{subject.node + ' ' if several else ''}{subject}" for subject, _ in rows]
    width = max(map(len, names), default=0)
    for name, (_, row) in zip(names, rows, strict=True):
        yield f"  {name:{width}}  {percent(row.share):>8}  {row.agreed} of {row.total}"


def _differences(agreement: Agreement) -> Iterator[str]:
    for difference in agreement.differences.values():
        yield ""
        yield from account(difference)


def _unexercised(agreement: Agreement) -> Iterator[str]:
    for node, lines in agreement.unexercised.items():
        if lines:
            yield ""
            yield f"never exercised of {node}:"
            yield from (f"  {line}" for line in lines)


def account(difference: Difference) -> Iterator[str]:
    """A difference in some lines."""
    yield headline(difference)
    for name, lines in _sides(difference.account).items():
        for place, line in enumerate(lines):
            yield f"  {name if not place else '':8}{line}"


def headline(difference: Difference) -> str:
    """What it is, how often, and when first."""
    times = f", {difference.count} times" if difference.count > 1 else ""
    first = f"first at {difference.tick / MICROSECONDS:.6f} s: {difference.account.text}"
    return f"{difference.subject}: {difference.kind}{times}, {first}"


def _sides(told: Account) -> Mapping[str, Sequence[str]]:
    return {"device": told.device, "twin": told.twin, "why": told.why}


def as_json(agreement: Agreement) -> str:
    """For programs, in one line."""
    return json.dumps(
        {
            "version": VERSION,
            "agreed": agreement.agreed,
            "total": agreement.total,
            "share": agreement.share,
            "rows": [
                {**subject._asdict(), "agreed": row.agreed, "total": row.total}
                for subject, row in agreement.rows.items()
            ],
            "differences": [_as_object(each) for each in agreement.differences.values()],
            "never_exercised": agreement.unexercised,
            "remarks": agreement.remarks,
        }
    )


def _as_object(difference: Difference) -> Mapping[str, object]:
    return {
        **difference.subject._asdict(),
        "kind": difference.kind.name.lower(),
        "time": difference.tick / MICROSECONDS,
        "count": difference.count,
        "text": difference.account.text,
        **_sides(difference.account),
    }


HEAD = """\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{title}</title>
<style>
body {{ font-family: sans-serif; color: #222; max-width: 75rem; margin: 1rem; }}
table {{ border-collapse: collapse; }}
th, td {{ text-align: left; padding: 0.15rem 1rem 0.15rem 0; }}
td + td {{ text-align: right; font-variant-numeric: tabular-nums; }}
.differs {{ background: #fdd; }}
pre {{ white-space: pre-wrap; overflow-wrap: anywhere; background: #f4f4f4; padding: 0.5rem; }}
</style>
</head>
<body>
<h1>{title}</h1>
"""


def as_page(agreement: Agreement, title: str) -> str:
    """One HTML file that needs no other and no network."""
    parts = [HEAD.format(title=escape(title))]
    parts += [f"<p>{escape(line)}</p>\n" for line in _head(agreement)]
    parts += ["<table>\n", *map(_row, agreement.rows, agreement.rows.values()), "</table>\n"]
    for difference in agreement.differences.values():
        first, *lines = account(difference)
        parts.append(f"<h3>{escape(first)}</h3>\n<pre>{escape(chr(10).join(lines))}</pre>\n")
    parts.append(f"<pre>{escape(chr(10).join(_unexercised(agreement)).strip())}</pre>\n")
    return "".join([*parts, "</body>\n</html>\n"])


def _row(subject: Subject, row: Row) -> str:
    cells = [f"{subject.node} {subject}", percent(row.share), f"{row.agreed} of {row.total}"]
    kind = ' class="differs"' if row.differed else ""
    return f"<tr{kind}>{''.join(f'<td>{escape(cell)}</td>' for cell in cells)}</tr>\n"
