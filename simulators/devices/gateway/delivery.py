"""How a governor and its gateway are delivered: tables of od/, settings, and a configuration."""

import csv
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from simulators.devices.gateway.configuration_file import read_configuration
from simulators.devices.gateway.model.assignment import Assignment, assignment
from simulators.devices.gateway.model.machines import Tables
from simulators.devices.gateway.model.options import Options
from simulators.devices.gateway.model.outputs import FirstTpdo
from simulators.devices.gateway.model.parameters import Catalogue
from simulators.devices.gateway.model.scaling import Scaling, scaling
from simulators.devices.gateway.model.system import System
from simulators.devices.gateway.model.table import catalogue
from simulators.devices.gateway.settings import Settings
from simulators.documents.document import Item, understand
from simulators.errors import UserError
from simulators.resources import od_file

LARGEST_FILE = 1 << 20  # bytes
OWN_NODE = 427

Content = Mapping[str, Mapping[int, float]]


def system(settings: Settings) -> System:
    """Both units with their power off and factory parameters.

    Raises:
        UserError: a file that cannot be used, or times that do not fit.
    """
    known = _parameters()
    tables = Tables(known, _scaling(known, settings.scaling), _assignment(settings.error_bits))
    options = Options(
        governor_cycle=settings.governor_cycle,
        boot_time=settings.boot_time,
        lowest_voltage=settings.lowest_voltage,
        first_tpdo=FirstTpdo(settings.first_tpdo),
        always_armed=settings.arm == "operational",
    )
    try:
        return System(tables, options)
    except ValueError as refusal:
        raise UserError(f"a setting in seconds: {refusal}") from refusal


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
def _found(name: str) -> Iterator[Path]:
    """A file, or one of od/ by its name."""
    with od_file(name) as shipped:
        yield shipped if shipped.exists() and not Path(name).exists() else Path(name)


@cache
def _parameters() -> Catalogue:
    with od_file("gateway_parameters.csv") as path:
        return catalogue(_rows(path))


def _scaling(known: Catalogue, file: str) -> Scaling:
    if not file:
        return _shipped_scaling()
    try:
        return scaling(known, _rows(Path(file)))
    except (OSError, ValueError) as refusal:
        raise UserError(f"{file}: {refusal}") from refusal


@cache
def _shipped_scaling() -> Scaling:
    with od_file("gateway_scaling.csv") as path:
        return scaling(_parameters(), _rows(path))


def _assignment(file: str) -> Assignment:
    return understand(Path(file), _meaning) if file else _shipped_assignment()


@cache
def _shipped_assignment() -> Assignment:
    with od_file("gateway_errors.yaml") as path:
        return understand(path, _meaning)


def _meaning(table: Item) -> Assignment:
    content = table.content
    try:
        return assignment(content)
    except ValueError as refusal:
        raise UserError(str(refusal)) from refusal


def _rows(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(_text(path).splitlines()))


def _text(path: Path) -> str:
    if path.stat().st_size > LARGEST_FILE:
        raise ValueError(f"larger than {LARGEST_FILE} bytes")
    return path.read_text("utf-8")
