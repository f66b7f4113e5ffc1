"""Configuration files: parameters by unit, each by its number or name, checked one by one."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from simulators.devices.gateway.model.parameters import Catalogue, Unit
from simulators.documents.document import Item, Pair, understand
from simulators.documents.keys import values
from simulators.errors import UserError

VERSION = 1
UNITS = [unit.value for unit in Unit]


def read_configuration(path: Path, known: Catalogue) -> Mapping[str, Mapping[int, float]]:
    """The values of a file by unit and number.

    Raises:
        DocumentError: with a line for everything that is wrong, each with its place.
    """
    keys: dict[str, Callable[[Item], Any]] = {"version": _check_version}
    keys |= {unit.value: partial(_values, unit=unit, known=known) for unit in Unit}

    def content(file: Item) -> Mapping[str, Mapping[int, float]]:
        taken = values(file, keys, optional=UNITS)
        return {unit: taken[unit] for unit in UNITS if unit in taken}

    return understand(path, content)


def _check_version(version: Item) -> None:
    if version.whole != VERSION:
        raise version.wrong(f"version {version.text} is unknown; this is {VERSION}")


def _values(item: Item, unit: Unit, known: Catalogue) -> Mapping[int, float]:
    found: dict[int, float] = {}
    for pair in item.pairs.values():
        with item.problems.at(pair.key):
            number, value = _value(pair, unit, known)
            if number in found:
                raise UserError(f"{pair.key.text} is parameter {number}, which stands above")
            found[number] = value
    return found


def _value(pair: Pair, unit: Unit, known: Catalogue) -> tuple[int, float]:
    try:
        key = pair.key.value
        parameter = known.find(unit, key if isinstance(key, int) else pair.key.text)
    except ValueError as refusal:
        raise pair.key.wrong(str(refusal)) from refusal
    if not parameter.writable:
        raise pair.key.wrong(f"{parameter.title}: is only shown")
    try:
        return parameter.number, parameter.checked(pair.value.number)
    except ValueError as refusal:
        raise pair.value.wrong(str(refusal)) from refusal
