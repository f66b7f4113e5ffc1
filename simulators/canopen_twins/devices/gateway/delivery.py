"""Configuration files: parameters by unit, each by its number or name, checked one by one."""

import csv
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from typing import Any

from canopen_twins.device.timing import IDEAL, Timing
from canopen_twins.devices.gateway.model.canopen_side import FirstTpdo
from canopen_twins.devices.gateway.model.configuration import OWN_NODE
from canopen_twins.devices.gateway.model.engine import Engine
from canopen_twins.devices.gateway.model.errors import Assignment, assignment
from canopen_twins.devices.gateway.model.parameters import (
    Catalogue,
    Scaling,
    Unit,
    catalogue,
    scaling,
)
from canopen_twins.devices.gateway.model.system import System
from canopen_twins.devices.gateway.model.unit import Options, Tables
from canopen_twins.devices.gateway.settings import Settings
from canopen_twins.errors import UserError
from canopen_twins.files.document import Item, Pair, understand, values
from canopen_twins.files.shipped import od_file
from canopen_twins.files.whole import read_plain

VERSION = 1
UNITS = [unit.value for unit in Unit]
LARGEST_FILE = 1 << 20  # bytes
SPEED_NOISE = {"ideal": 0.0, "typical": 1.0, "worst": 4.0}  # rpm, by `timing`

Content = Mapping[str, Mapping[int, float]]


def read_configuration(path: Path, known: Catalogue) -> Content:
    """The values of a file by unit and number.

    Raises:
        DocumentError: with a line for everything that is wrong, each with its place.
    """
    keys: dict[str, Callable[[Item], Any]] = {"version": _check_version}
    keys |= {unit.value: partial(_values, unit=unit, known=known) for unit in Unit}

    def content(file: Item) -> Content:
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


def system(settings: Settings, timing: Timing = IDEAL, engine: Engine | None = None) -> System:
    """Both units with their power off and factory parameters; without an engine a new one.

    Raises:
        UserError: a file that cannot be used, or times that do not fit.
    """
    tables = Tables(
        _parameters(),
        _scaling(settings.scaling) if settings.scaling else _shipped_scaling(),
        understand(Path(settings.error_bits), _meaning)
        if settings.error_bits
        else _shipped_assignment(),
    )
    options = Options(
        governor_cycle=settings.governor_cycle,
        boot_time=settings.boot_time,
        lowest_voltage=settings.lowest_voltage,
        first_tpdo=FirstTpdo(settings.first_tpdo),
        always_armed=settings.arm == "operational",
        answer_time=timing.answer_time,
        speed_noise=SPEED_NOISE[settings.timing]
        if settings.speed_noise is None
        else settings.speed_noise,
        seed=settings.seed,
    )
    with refusals("a setting in seconds: "):
        return System(tables, options, engine)


def configuration(settings: Settings) -> Content:
    """The parameters both units are delivered with, as far as they are not those of the factory.

    Raises:
        UserError: with a line for everything that is wrong with the file.
    """
    content: Content = {}
    if settings.config:
        with _found(settings.config) as file:
            content = read_configuration(file, _parameters())
    if settings.node_id is None:
        return content
    return {**content, "gateway": {**content.get("gateway", {}), OWN_NODE: settings.node_id}}


@contextmanager
def refusals(of: str = "") -> Iterator[None]:
    """What the model refuses is an error of the user.

    Raises:
        UserError: in place of a ValueError, after the words `of`.
    """
    try:
        yield
    except ValueError as refusal:
        raise UserError(f"{of}{refusal}") from refusal


@contextmanager
def _found(name: str) -> Iterator[Path]:
    """A file, or one of od/ by its name."""
    with od_file(name) as shipped:
        yield shipped if shipped.exists() and not Path(name).exists() else Path(name)


@cache
def _parameters() -> Catalogue:
    with od_file("gateway_parameters.csv") as path:
        return catalogue(_rows(path))


@cache
def _shipped_scaling() -> Scaling:
    with od_file("gateway_scaling.csv") as path:
        return scaling(_parameters(), _rows(path))


@cache
def _shipped_assignment() -> Assignment:
    with od_file("gateway_errors.yaml") as path:
        return understand(path, _meaning)


def _scaling(file: str) -> Scaling:
    try:
        return scaling(_parameters(), _rows(Path(file)))
    except UserError:  # which says what file it is
        raise
    except (ValueError, csv.Error) as refusal:
        raise UserError(f"{file}: {refusal}") from refusal


def _meaning(table: Item) -> Assignment:
    content = table.content
    with refusals():
        return assignment(content)


def _rows(path: Path) -> list[dict[str, str]]:
    """The rows of a table, each with all of its columns."""
    reader = csv.DictReader(read_plain(path, LARGEST_FILE).decode("utf-8").splitlines())
    rows = []
    for row in reader:
        if None in row or None in row.values():
            raise ValueError(f"line {reader.line_num}: not as many fields as there are columns")
        rows.append(row)
    if not rows:
        raise ValueError("there is no row below the names of the columns")
    return rows
