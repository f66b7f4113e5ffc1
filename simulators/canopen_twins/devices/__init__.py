"""The devices there are: a package in this folder is one, and so is an entry point of a group.

There is no list to extend: a device of this project brings a package here, one of somebody else's
project an entry point in the group `canopen_twins.devices` (name = "package:Class").
"""

from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from pkgutil import iter_modules
from typing import TypeAlias

from canopen_twins.device.device import Device
from canopen_twins.errors import UserError, unknown

GROUP = "canopen_twins.devices"
OF_FILES = "eds"  # the package of devices that are described by a file
YAML = (".yaml", ".yml")
FILES = (".eds", ".dcf", ".xdd", ".xdc", *YAML)
"""Suffixes of files that describe a device."""
What: TypeAlias = str | Path | type[Device]
"""A device by its name, by its file, or by its class."""


def names() -> list[str]:
    """The names of all devices, also of those that `find` refuses."""
    return sorted({*_shipped(), *_installed()})


def is_file(name: str) -> bool:
    """Whether a name is the path of a file that describes a device."""
    return name.lower().endswith(FILES)


def tells_of_device(name: str) -> bool:
    """Whether a name is such a file; of YAML files those are that say which EDS they have."""
    suffixes = [suffix.lower() for suffix in Path(name).suffixes]
    if not suffixes or suffixes[-1] not in YAML or suffixes[-2:-1] == [".device"]:
        return is_file(name)
    from canopen_twins.files.document import understand  # noqa: PLC0415 - most processes need none

    try:
        return understand(Path(name), lambda file: "eds" in file.pairs)
    except UserError:
        return False


def find(name: str, beside: Path | None = None) -> type[Device]:
    """The class of a device.

    Args:
        name: Of a device, or the path of a file that describes one.
        beside: The folder where a relative path begins; the working directory without one.

    Raises:
        UserError: there is no device of this name, or several, or it cannot be imported; there is
            no such file, or it describes no device.
    """
    if is_file(name):
        path = (beside or Path()) / name
        if path.suffix.lower() in YAML:
            from canopen_twins.devices.eds import compile as device_files  # noqa: PLC0415 - pydantic

            return device_files.device_of(path)
        from canopen_twins.devices import eds  # noqa: PLC0415 - most processes need none

        return eds.device_of(path)
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


def create(what: What, **settings: object) -> Device:
    """A device by its name, its file or its class, with its power off.

    Raises:
        UserError: no such device, or settings that are unknown or of the wrong kind.
    """
    return (what if isinstance(what, type) else find(str(what)))(**settings)


def name_of(what: What) -> str:
    """What a node is called that is named after its device."""
    return what.__name__ if isinstance(what, type) else str(what)


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
