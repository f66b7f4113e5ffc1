"""The devices there are: a package in this folder is one, and so is an entry point of a group.

There is no list to extend: a device of this project brings a package here, one of somebody else's
project an entry point in the group `canopen_twins.devices` (name = "package:Class").
"""

from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from pkgutil import iter_modules

from canopen_twins.device.device import Device
from canopen_twins.errors import UserError, unknown

GROUP = "canopen_twins.devices"
OF_FILES = "eds"  # the package of devices that are described by a file
FILES = (".eds", ".dcf", ".xdd", ".xdc")
"""Suffixes of files that describe a device."""


def names() -> list[str]:
    """The names of all devices, also of those that `find` refuses."""
    return sorted({*_shipped(), *_installed()})


def find(name: str, beside: Path | None = None) -> type[Device]:
    """The class of a device.

    Args:
        name: Of a device, or the path of a file that describes one.
        beside: The folder where a relative path begins; the working directory without one.

    Raises:
        UserError: there is no device of this name, or several, or it cannot be imported; there is
            no such file, or it describes no device.
    """
    if name.lower().endswith(FILES):
        from canopen_twins.devices import eds  # noqa: PLC0415 - most processes need none

        return eds.device_of((beside or Path()) / name)
    if name not in names():
        told = str(unknown("device", name, names()))
        near = told.endswith("?")
        raise UserError(told if near else f"{told}; a path to an EDS file is one, too")
    installed = _installed().get(name, ())
    if name in _shipped() and not installed:
        device: type[Device] = import_module(f"{__name__}.{name}").Device
        return device
    if name in _shipped() or len(installed) > 1:
        owners = ["canopen-twins"] * (name in _shipped()) + [_owner(each) for each in installed]
        raise UserError(f"device {name!r} comes from {' and from '.join(owners)}: remove one")
    return _imported(installed[0])


def create(name: str, **settings: object) -> Device:
    """A device by its name, with its power off.

    Raises:
        UserError: no such device, or settings that are unknown or of the wrong kind.
    """
    return find(name)(**settings)


@cache
def _shipped() -> frozenset[str]:
    return frozenset(module.name for module in iter_modules(__path__)) - {OF_FILES}


@cache
def _installed() -> dict[str, tuple[EntryPoint, ...]]:
    found: dict[str, tuple[EntryPoint, ...]] = {}
    for entry in entry_points(group=GROUP):
        found[entry.name] = (*found.get(entry.name, ()), entry)
    return found


def _imported(entry: EntryPoint) -> type[Device]:
    try:
        device = entry.load()
    except (ImportError, AttributeError) as failure:
        raise UserError(f"device {entry.name!r} of {_owner(entry)}: {failure}") from failure
    if not (isinstance(device, type) and issubclass(device, Device)):
        raise UserError(f"device {entry.name!r} of {_owner(entry)}: {entry.value} is no Device")
    try:
        device.complete()
    except UserError as mistake:
        raise UserError(f"device {entry.name!r} of {_owner(entry)}: {mistake}") from None
    return device


def _owner(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist else entry.value
