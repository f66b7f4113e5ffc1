"""What a comparison has found, in words."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.record.compare.agreement import Agreement, Difference


def text(agreement: Agreement) -> str:
    """For people: what agrees how far, then each difference with its frames."""
    return "\n".join([*_head(agreement), *_rows(agreement), *_differences(agreement)])


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


def account(difference: Difference) -> Iterator[str]:
    """A difference in some lines."""
    times = f", {difference.count} times" if difference.count > 1 else ""
    at = f"{difference.tick / MICROSECONDS:.6f} s"
    told = difference.account
    yield f"{difference.subject}: {difference.kind}{times}, first at {at}: {told.text}"
    sides: Mapping[str, Iterable[str]] = {
        "device": told.device,
        "twin": told.twin,
        "why": told.why,
    }
    for name, lines in sides.items():
        for place, line in enumerate(lines):
            yield f"  {name if not place else '':8}{line}"
