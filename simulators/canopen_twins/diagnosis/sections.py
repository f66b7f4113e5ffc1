"""Where the manual of a device says what: a table of od/ beside its EDS, for people who look it up.

The table of `charger_pcsc_a.eds` is `charger_pcsc_a_sections.csv`, `charger_pcsc_sections.csv` or
`charger_sections.csv`, the first there is. A device without one has no sections.
"""

import csv
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

from canopen_twins.files.shipped import od_file
from canopen_twins.slave.object import Address

KINDS = ("object", "service", "emcy")
ANY = "any"

Row = Mapping[str, str]


class Sections:
    """Sources of objects, of services and of emergencies; empty where the table has none."""

    def __init__(self, rows: Iterable[Row] = ()) -> None:
        """Raises `ValueError` for a row that is about nothing known, or stands there twice."""
        self._known: dict[tuple[str, object], str] = {}
        for row in rows:
            for key in _keys(row):
                if key in self._known:
                    raise ValueError(f"{row} stands there twice")
                self._known[key] = row["source"]

    def object(self, address: Address) -> str:
        """Of an entry, or of the object it belongs to."""
        index, subindex = address
        whole = self._known.get(("object", (index, None)), "")
        return self._known.get(("object", (index, subindex)), whole)

    def service(self, name: str) -> str:
        """Of nmt, heartbeat, sdo, pdo, emcy, lss, of states or of silence."""
        return self._known.get(("service", name), "")

    def emcy(self, code: int) -> str:
        """Of an emergency error code."""
        return self._known.get(("emcy", code), self._known.get(("emcy", ANY), ""))


@cache
def sections(eds: str) -> Sections:
    """The table of a device by the `eds` it names: a file of od/, or a path."""
    return Sections(table(eds, "sections"))


def table(eds: str, kind: str) -> list[Row]:
    """The rows of a table beside an EDS, none if it has no such table."""
    stem = Path(eds).stem
    while stem:
        with od_file(str(Path(eds).with_name(f"{stem}_{kind}.csv"))) as path:
            if path.is_file():
                with path.open(newline="", encoding="utf-8") as file:
                    return list(csv.DictReader(file))
        stem = stem.rpartition("_")[0]
    return []


def _keys(row: Row) -> Iterator[tuple[str, object]]:
    kind, of = row["what"], row["of"]
    if kind not in KINDS:
        raise ValueError(f"{row}: nothing of {', '.join(KINDS)}")
    if kind == "object":
        index, colon, subindex = of.partition(":")
        subs = _numbers(subindex) if colon else (None,)
        yield from ((kind, (each, sub)) for each in _numbers(index) for sub in subs)
    else:
        yield kind, int(of, 16) if kind == "emcy" and of != ANY else of


def _numbers(text: str) -> range:
    """`2014`, or `1400-1403`."""
    first, _, last = text.partition("-")
    return range(int(first, 16), int(last or first, 16) + 1)
