"""Configuration files: parameters by unit, each by its number or name, checked one by one."""

from collections.abc import Mapping
from pathlib import Path

from simulators.devices.gateway.model.parameters import Catalogue, Unit
from simulators.documents.document import Item, Pair, read
from simulators.documents.problems import Problems
from simulators.errors import UserError

VERSION = 1
UNITS = [unit.value for unit in Unit]


def read_configuration(path: Path, known: Catalogue) -> Mapping[str, Mapping[int, float]]:
    """The values of a file by unit and number.

    Raises:
        DocumentError: with a line for everything that is wrong, each with its place.
    """
    problems = Problems(str(path))
    fields = read(path, problems).fields(("version",), UNITS)
    if "version" in fields:
        with problems.at(fields["version"]):
            if fields["version"].whole != VERSION:
                raise UserError(f"version {fields['version'].text} is unknown; this is {VERSION}")
    content = {unit: _values(fields[unit], Unit(unit), known) for unit in UNITS if unit in fields}
    problems.settle()
    return content


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
