"""run.json of a record: who took part, with which settings, memory and versions of everything."""

import json
import platform
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, fields
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, entry_points, version
from os.path import commonpath
from pathlib import Path
from typing import Any, Literal, TypeAlias

from pydantic import BaseModel, ValidationError

from canopen_twins import devices
from canopen_twins.device.device import Device
from canopen_twins.device.settings import about
from canopen_twins.errors import UserError
from canopen_twins.scenario import Scenario
from canopen_twins.slave.memory import Memory

FORMAT = 1  # of the whole record
LARGEST_FILE = 1 << 23  # bytes; a memory is at most 1 MiB
PACKAGES = ("canopen-twins", "canopen", "python-can")
PYTHON = "python"
DEVICES = "devices"  # the folder in a record of what describes them

Value: TypeAlias = bool | int | float | str | None


class Participant(BaseModel, frozen=True, extra="forbid", strict=True):
    """A node, as it was when its power came."""

    name: str
    device: str
    """Its name, or the path in the record of the file that describes it."""
    settings: dict[str, Value]
    memory: dict[str, dict[str, Any]]

    def create(self, folder: Path) -> Device:
        """The same device once more, with its power off.

        Args:
            folder: Of the record, where the files are that describe devices.

        Raises:
            UserError: there is none like this any more.
        """
        device = devices.find(self.device, folder)(**self.settings)
        device.memory = Memory()
        for section, values in self.memory.items():
            device.memory.store(section, values)
        return device


class Manifest(BaseModel, frozen=True, extra="forbid", strict=True):
    """All that has to be known to live through a run again, beside its scenario and its events."""

    format: Literal[1] = 1
    kind: Literal["play", "run"]
    """In simulated time, or beside a master in real time."""
    scenario: str | None
    """As the command named it."""
    seed: int | None
    nodes: list[Participant]
    """In the order in which they hear a frame."""
    files: dict[str, str]
    """The files that settings name, and the SHA-256 of each."""
    versions: dict[str, str]

    @classmethod
    def of(
        cls,
        kind: Literal["play", "run"],
        scenario: Scenario | None,
        participants: Mapping[str, Device],
    ) -> "Manifest":
        """What there is to say before a run begins.

        Raises:
            UserError: a device that cannot be had by a name.
        """
        copies = copied(participants.values())
        nodes = [_participant(name, device, copies) for name, device in participants.items()]
        return cls(
            kind=kind,
            scenario=None if scenario is None else str(scenario.file),
            seed=None if scenario is None else scenario.seed,
            nodes=nodes,
            files={name: digest(Path(name)) for name in sorted(_files(participants.values()))},
            versions=_versions(node.device for node in nodes),
        )

    @property
    def text(self) -> str:
        """The content of the file."""
        return json.dumps(self.model_dump(), indent=1, sort_keys=True) + "\n"


def read_manifest(path: Path) -> Manifest:
    """What a run.json says.

    Raises:
        UserError: it is missing, damaged, or of another format.
    """
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise ValueError(f"larger than {LARGEST_FILE} bytes")
        content = json.loads(path.read_text("utf-8"))
        json.dumps(content, ensure_ascii=False).encode("utf-8")  # no half of a character
        if isinstance(content, dict) and content.get("format", FORMAT) != FORMAT:
            told = content["format"]
            raise UserError(f"{path}: format {told!r} is unknown; this program reads {FORMAT}")
        return Manifest.model_validate(content)
    except UserError:
        raise
    except OSError as failure:
        raise UserError(f"{path}: {failure.strerror}") from failure
    except ValidationError as damage:
        first = damage.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise UserError(f"{path} is damaged: {where}: {first['msg']}") from damage
    except (ValueError, RecursionError) as damage:
        raise UserError(f"{path} is damaged: {damage}") from damage


def digest(path: Path) -> str:
    """The SHA-256 of a file."""
    return sha256(path.read_bytes()).hexdigest()


def version_now(name: str) -> str:
    """The version of a package, or of Python, that is here."""
    if name == PYTHON:
        return platform.python_version()
    try:
        return version(name)
    except PackageNotFoundError:
        return "none"


def _versions(names: Iterable[str]) -> dict[str, str]:
    """By the names of packages, also of those that bring some of the devices."""
    owners = {
        entry.dist.name
        for name in names
        for entry in entry_points(group=devices.GROUP, name=name)
        if entry.dist is not None
    }
    return {name: version_now(name) for name in (*PACKAGES, *sorted(owners), PYTHON)}


def copied(participants: Iterable[Device]) -> dict[tuple[Path, ...], dict[Path, str]]:
    """The files that describe devices, and where they are in the record.

    Each device has a folder, in which they lie as they lay to each other.
    """
    found: dict[tuple[Path, ...], dict[Path, str]] = {}
    kinds = dict.fromkeys(device.files for device in participants if device.files)
    for number, files in enumerate(kinds, 1):
        above = commonpath([file.parent for file in files])
        folder = Path(DEVICES, str(number))
        found[files] = {file: (folder / file.relative_to(above)).as_posix() for file in files}
    return found


def device_files(participants: Iterable[Device]) -> dict[str, bytes]:
    """What a record keeps of them, by their paths in it.

    Raises:
        UserError: one cannot be read any more.
    """
    places = [place for files in copied(participants).values() for place in files.items()]
    try:
        return {path: file.read_bytes() for file, path in places}
    except OSError as failure:
        raise UserError(f"{failure.filename}: {failure.strerror}") from failure


def _participant(
    name: str, device: Device, copies: Mapping[tuple[Path, ...], Mapping[Path, str]]
) -> Participant:
    memory = {section: dict(values) for section, values in device.memory.content.items()}
    told = asdict(device.settings)
    files = device.files
    kind = copies[files][files[0]] if files else _name(type(device))
    return Participant(name=name, device=kind, settings=told, memory=memory)


def _name(device: type[Device]) -> str:
    for name in devices.names():
        with suppress(UserError):  # one that is broken is somebody else
            if devices.find(name) is device:
                return name
    raise UserError(f"{device.__name__} is no device of `canopen-twin list`: it has no record")


def _files(participants: Iterable[Device]) -> set[str]:
    """Those that settings name: what is called like the value of another setting is none."""
    return {
        value
        for device in participants
        for entry in fields(device.settings)
        if about(entry).file and (value := getattr(device.settings, entry.name))
        if Path(value).is_file()
    }
