"""What a value replays: a CSV file of seconds and values."""

import csv
from math import isfinite
from pathlib import Path

from canopen_twins.devices.eds import model
from canopen_twins.errors import UserError, unknown

LARGEST_CSV = 16 * 1024 * 1024  # bytes


def read_samples(path: Path, column: str | None) -> list[model.Sample]:
    """Rows of seconds and values; the first row may have the names of the columns.

    Raises:
        UserError: it cannot be read, has no such column, or a row is wrong.
    """
    rows = _rows(path)
    place = 1
    if rows and not _is_number(rows[0][1][0]):
        heads = [head.strip() for head in rows.pop(0)[1]]
        if column is not None:
            if column not in heads:
                raise UserError(f"{path.name}: {unknown('column', column, heads)}")
            place = heads.index(column)
    elif column is not None:
        raise UserError(f"{path.name}: the first row has no names of columns")
    samples: list[model.Sample] = []
    for number, row in rows:
        where = f"{path.name}:{number}"
        if len(row) <= place or not (_is_number(row[0]) and _is_number(row[place])):
            raise UserError(f"{where}: wanted are seconds and a value, not {','.join(row)!r}")
        sample = model.Sample(float(row[0]), float(row[place]))
        if sample.time < (samples[-1].time if samples else 0):
            raise UserError(f"{where}: {row[0]} s is before the row above")
        samples.append(sample)
    if not samples:
        raise UserError(f"{path.name}: there is no row of seconds and a value")
    return samples


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """Those that are not empty, with their numbers."""
    try:
        if path.stat().st_size > LARGEST_CSV:
            raise UserError(f"{path} is larger than {LARGEST_CSV // 1024 // 1024} MiB")
        with path.open(newline="", encoding="utf-8-sig") as file:
            return [(number, row) for number, row in enumerate(csv.reader(file), 1) if any(row)]
    except OSError as failure:
        raise UserError(f"{path}: {failure.strerror}") from failure
    except (UnicodeDecodeError, csv.Error) as failure:
        raise UserError(f"{path}: {failure}") from failure


def _is_number(text: str) -> bool:
    try:
        return isfinite(float(text))
    except ValueError:
        return False
