"""Configuration files: parameters by unit, each by its number or name, checked one by one."""

from collections.abc import Mapping
from pathlib import Path

from simulators.devices.gateway.model.parameters import Catalogue, Unit
from simulators.documents.document import Item, Pair, read
from simulators.documents.problems import Problems
from simulators.errors import UserError, unknown

VERSION_KEY, VERSION = "version", 1
UNITS = [unit.value for unit in Unit]


def read_configuration(path: Path, known: Catalogue) -> Mapping[str, Mapping[int, float]]:
    """The values of a file by unit and number.

    Raises:
        DocumentError: with a line for everything that is wrong, each with its place.
    """
    problems = Problems(str(path))
    content = {}
    with problems.at(file := read(path, problems)):
        _check_version(file)
        for name, pair in file.pairs.items():
            if name in UNITS:
                content[name] = _values(pair.value, Unit(name), known)
            elif name != VERSION_KEY:
                problems.add(pair.key.mark, str(unknown("key", name, (VERSION_KEY, *UNITS))))
    problems.settle()
    return content


def _check_version(file: Item) -> None:
    with file.problems.at(file):
        if VERSION_KEY not in file.pairs:
            raise UserError(f"{VERSION_KEY!r} is missing")
        version = file.pairs[VERSION_KEY].value
        if version.whole != VERSION:
            raise version.wrong(f"version {version.text} is unknown; this is {VERSION}")


def _values(item: Item, unit: Unit, known: Catalogue) -> Mapping[int, float]:
    values: dict[int, float] = {}
    with item.problems.at(item):
        for pair in item.pairs.values():
            with item.problems.at(pair.key):
                number, value = _value(pair, unit, known)
                if number in values:
                    raise UserError(f"{pair.key.text} is parameter {number}, which stands above")
                values[number] = value
    return values


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
