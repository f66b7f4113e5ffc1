"""Tolerances as users write them: 5ms, 1%, 3 digits, and a file with those of single objects."""

import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Annotated

from pydantic import ConfigDict

from canopen_twins.bus.clock import microseconds
from canopen_twins.device.device import Device
from canopen_twins.errors import UserError
from canopen_twins.files.convert import TIMES
from canopen_twins.files.document import Item
from canopen_twins.files.leaves import File, Named
from canopen_twins.files.table import Leaf, understand_table
from canopen_twins.record.compare.tolerances import Allowed, Tolerances
from canopen_twins.scenario.targets import Targets
from canopen_twins.slave.object import Address

QUANTITY = re.compile(r"(\d+(?:\.\d+)?) ?(\S*)")
IGNORE = "ignore"


def time_of(text: str) -> int:
    """Microseconds of 5ms, 0.005 or 0.005s.

    Raises:
        UserError: it is no time.
    """
    found = QUANTITY.fullmatch(text)
    if found is None or found[2] not in ("", *TIMES):
        raise UserError(f"{text!r} is no time: write it as 5ms or 0.005s")
    return microseconds(float(found[1]) * TIMES[found[2] or "s"])


def allowed_of(text: str) -> Allowed:
    """1% of a value, or 3 digits of it.

    Raises:
        UserError: it is neither.
    """
    found = QUANTITY.fullmatch(text)
    if found is None or found[2] not in ("", "%"):
        raise UserError(f"{text!r} is no tolerance: write 1% of a value, or 3 for digits")
    number = float(found[1])
    return Allowed(share=number / 100) if found[2] else Allowed(digits=number)


def share_of(text: str) -> float:
    """From 0 to 1, of 2%.

    Raises:
        UserError: it is no share.
    """
    found = QUANTITY.fullmatch(text)
    if found is None or found[2] != "%" or float(found[1]) > 100:
        raise UserError(f"{text!r} is no share: write it as 2%")
    return float(found[1]) / 100


def _object(item: Item) -> Allowed | None:
    with item.blamed():
        return None if item.text == IGNORE else allowed_of(item.text)


def _time(item: Item) -> int:
    with item.blamed():
        return time_of(item.text)


def _value(item: Item) -> Allowed:
    with item.blamed():
        return allowed_of(item.text)


QUANTITIES = {"type": ["string", "number"]}


class ToleranceFile(File):
    """How far a device and its twin may be apart."""

    model_config = ConfigDict(title="Tolerances")

    time: Annotated[int, Leaf(_time, QUANTITIES)] | None = None
    """Of a time: 5ms."""
    value: Annotated[Allowed, Leaf(_value, QUANTITIES)] | None = None
    """Of a measured value: 1% or digits."""
    objects: Named[Annotated[Allowed | None, Leaf(_object, QUANTITIES)]] | None = None
    """Of single objects, by names or addresses: 1%, digits, or `ignore`."""


def read_tolerances(path: Path, devices: Iterable[Device]) -> Tolerances:
    """What a file says, with the names of the dictionaries of devices.

    Raises:
        DocumentError: with a line for everything that is wrong.
    """
    targets = [Targets(device.dictionary()) for device in devices]

    def mean(file: ToleranceFile) -> Tolerances:
        usual = Tolerances()
        objects = {}
        for name, allowed in (file.objects or {}).items():
            with name.problems.at(name):
                objects[_address(targets, name.text)] = allowed
        time = usual.time if file.time is None else file.time
        return Tolerances(time, file.value or usual.value, objects)

    return understand_table(path, ToleranceFile, mean)


def _address(targets: Sequence[Targets], name: str) -> Address:
    """In the first dictionary that has it; what the last one says of a name in none."""
    for each in targets[:-1]:
        with suppress(UserError):
            return each.find(name).address
    return targets[-1].find(name).address
