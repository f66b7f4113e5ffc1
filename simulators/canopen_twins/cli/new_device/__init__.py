"""new-device: a package to start from, with the EDS one has."""

import argparse
from collections.abc import Iterator, Mapping
from importlib.resources import files
from keyword import iskeyword
from pathlib import Path
from string import Template
from typing import NamedTuple

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import INTEGER_TYPES, SIGNED_TYPES

from canopen_twins import devices
from canopen_twins.cli.command import OK, Parser
from canopen_twins.devices.eds import described
from canopen_twins.errors import UserError
from canopen_twins.slave.dictionary import address_text, entries
from canopen_twins.slave.object import Address

APPLICATION = 0x2000
ERROR_REGISTER = 0x1001  # there is no EMCY without (CiA 301, 7.5.2.2)
TRIED = (100, 10, 1)  # values for the first test


def add_new_device(parser: Parser) -> None:
    """new-device."""
    text = "what people will type; a folder canopen-NAME is made here"
    parser.add_argument("name", metavar="NAME", help=text)
    parser.add_argument("--eds", metavar="FILE", help="its EDS; a small one is written without")
    parser.set_defaults(command=new_device)


def new_device(options: argparse.Namespace) -> int:
    """Write the package, and say what to do with it."""
    name: str = options.name
    if not name.isidentifier() or not name.islower() or iskeyword(name):
        raise UserError(f"{name!r} is no name of a device; they look like big_pump")
    if name in devices.names():
        raise UserError(f"there is a device {name!r} already: take another name")
    folder = Path(f"canopen-{name.replace('_', '-')}")
    package = package_of(name, None if options.eds is None else Path(options.eds))
    _write(folder, package)
    for file in package:
        print(folder / file)
    print(f"\nTry it: cd {folder} && pip install -e . && python -m pytest")
    return OK


def package_of(name: str, eds: Path | None) -> Mapping[str, bytes]:
    """The files of the package of a device, by their paths.

    Raises:
        UserError: the EDS cannot be read, or describes no device.
    """
    words = name.replace("_", " ")
    told = {
        "name": name,
        "words": words,
        "title": f"Example {words}",
        "class": "".join(map(str.capitalize, name.split("_"))),
        "project": f"canopen-{name.replace('_', '-')}",
        "package": f"canopen_{name}",
        "eds": f"{name}.eds" if eds is None else eds.name,
    }
    if eds is None:
        content = _filled("device.eds", told)
        pair: Pair | None = SHIPPED
        emcy = True
    else:
        kind = described(eds)
        content = eds.read_bytes()
        od = kind().dictionary()
        pair, emcy = Pair.of(od), ERROR_REGISTER in od
        told["title"] = kind.title.replace("\\", "").replace('"', "'")
    package = told["package"]
    return {
        "pyproject.toml": _filled("pyproject.txt", told),
        f"{package}/__init__.py": _filled("device.txt", {**told, "objects": _objects(pair)}),
        f"{package}/model.py": _filled("model.txt", {**told, "default": _default(pair)}),
        f"{package}/py.typed": b"",
        f"{package}/{told['eds']}": content,
        f"{name}.twin.yaml": _filled("story.yaml", {**told, "steps": _story(pair, emcy)}),
        f"tests/test_{name}.py": _filled("test.txt", {**told, "tests": _tests(pair, emcy)}),
    }


class Entry(NamedTuple):
    """An entry of the dictionary."""

    address: Address
    alone: bool
    """Whether its object has no other."""

    @classmethod
    def of(cls, variable: ODVariable) -> "Entry":
        """Where an entry is."""
        alone = isinstance(variable.parent, ObjectDictionary)
        return cls((variable.index, variable.subindex), alone)

    @property
    def key(self) -> str:
        """As `objects` have it."""
        return f"(0x{self.address[0]:04X}, {self.address[1]})"

    @property
    def sdo(self) -> str:
        """As an SDO client has it."""
        return f"[0x{self.address[0]:04X}]" + ("" if self.alone else f"[{self.address[1]}]")

    @property
    def text(self) -> str:
        """As a scenario has it."""
        return f"0x{self.address[0]:04X}" if self.alone else address_text(self.address)


class Pair(NamedTuple):
    """An object that a master writes, one that follows it, and a value for a test."""

    target: Entry
    actual: Entry
    default: int
    value: int

    @classmethod
    def of(cls, od: ObjectDictionary) -> "Pair | None":
        """The first two of one type in a dictionary; None if there are none."""
        numbers = [
            variable
            for _, variable in entries(od)
            if variable.index >= APPLICATION and variable.data_type in INTEGER_TYPES
        ]
        measured = [each for each in numbers if each.readable and not each.writable]
        for target in (each for each in numbers if each.writable and each.readable):
            value = next(_values(target), None)
            actual = next((each for each in measured if each.data_type == target.data_type), None)
            if value is not None and actual is not None:
                return cls(Entry.of(target), Entry.of(actual), target.default or 0, value)
        return None


SHIPPED = Pair(Entry((0x2000, 0), True), Entry((0x2001, 0), True), 0, TRIED[0])


def _values(variable: ODVariable) -> Iterator[int]:
    """Values that an entry takes and does not have."""
    highest = (1 << len(variable) - (variable.data_type in SIGNED_TYPES)) - 1
    low = variable.min if variable.min is not None else 0
    high = variable.max if variable.max is not None else highest
    return (each for each in TRIED if low <= each <= high and each != (variable.default or 0))


def _filled(name: str, told: Mapping[str, str]) -> bytes:
    text = (files(__package__) / "template" / name).read_text("utf-8")
    return Template(text).substitute(told).encode("utf-8")


def _default(pair: Pair | None) -> str:
    return f"{float(pair.default if pair else 0)}"


def _objects(pair: Pair | None) -> str:
    if pair is None:
        return "        return {}\n"
    return (
        "        return {\n"
        f"            {pair.target.key}: device.Object(write=self.model.aim),\n"
        f"            {pair.actual.key}: device.Object(read=lambda: round(self.model.value)),\n"
        "        }\n"
    )


def _tests(pair: Pair | None, emcy: bool) -> str:
    follows = (
        ""
        if pair is None
        else (
            "\n\ndef test_it_follows_its_target(twin: Bench) -> None:\n"
            f"    twin.sdo{pair.target.sdo}.raw = {pair.value}\n"
            "    twin.run(30.0)\n"
            f"    assert twin.sdo{pair.actual.sdo}.raw == {pair.value}\n"
        )
    )
    told = (
        ""
        if not emcy
        else (
            "\n\ndef test_being_stuck_is_told(twin: Bench) -> None:\n"
            '    twin.inject("stuck")\n'
            "    twin.run(1.0)\n"
            '    assert any("#00FF81" in frame for frame in twin.sent)\n'
        )
    )
    return follows + told


def _story(pair: Pair | None, emcy: bool) -> str:
    follows = (
        ""
        if pair is None
        else (
            f"  - at: 0.2\n    write: {{{pair.target.text}: {pair.value}}}\n"
            f"  - at: 15\n    expect: {{value: {{{pair.actual.text}: {pair.value}}}}}\n"
        )
    )
    expected = "  - at: 20\n    expect: {emcy: {code: 0xFF00}, within: 1}\n" if emcy else ""
    return f"{follows}  - at: 20\n    inject: stuck\n{expected}"


def _write(folder: Path, package: Mapping[str, bytes]) -> None:
    if folder.exists():
        raise UserError(f"{folder} is there already, and nothing is overwritten")
    try:
        for name, content in package.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
    except OSError as failure:
        raise UserError(f"{folder} cannot be written: {failure.strerror}") from failure
