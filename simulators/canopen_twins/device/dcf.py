"""Device configuration files (CiA 306): the EDS of a device, with what it is after a boot."""

import re
from collections.abc import Iterator, Mapping
from configparser import RawConfigParser
from io import StringIO

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable

from canopen_twins.bus.clock import Clock
from canopen_twins.device.device import Device
from canopen_twins.device.node import Node, wait_for_boot
from canopen_twins.errors import UserError
from canopen_twins.files.shipped import od_file
from canopen_twins.slave.object import Entry
from canopen_twins.slave.slave import Slave

COMMUNICATION_AREA = range(0x1000, 0x2000)
ERRORS = (0x1001, 0x1003)
ENTRY = re.compile(r"([0-9A-F]{4})sub([0-9A-F]+)")
VARIABLE = "0x7"

Sections = dict[str, dict[str, str]]


def dcf(device: Device) -> str:
    """The text of the file: what the EDS does not have, and the parameters as they are.

    Raises:
        UserError: the device does not boot with these settings.
    """
    slave = _booted(device)
    sections = _read(device.eds)
    for entry in (entry for subs in slave.entries.values() for entry in subs.values()):
        keys = sections.setdefault(_section(entry, sections), _described(entry.variable))
        keys.update(_changed(entry))
    for name, subs in _records(slave, sections):
        sections[name]["SubNumber"] = str(subs)
    commissioning = {"NodeID": str(slave.node_id), "NodeName": device.title}
    return _text({"DeviceComissioning": commissioning, **_in_order(sections)})


def _booted(device: Device) -> Slave:
    node = Node(device, Clock())
    node.power_on()
    if not wait_for_boot([node], node.clock.advance) or node.slave is None:
        raise UserError("with these settings it does not boot")
    return node.slave


def _read(eds: str) -> Sections:
    parser = _parser()
    with od_file(eds) as path:
        parser.read(path, encoding="ascii")
    return {name: dict(parser[name]) for name in parser.sections()}


def _parser() -> RawConfigParser:
    parser = RawConfigParser(delimiters="=")
    parser.optionxform = str  # type: ignore[assignment, method-assign]
    return parser


def _section(entry: Entry, known: Mapping[str, object]) -> str:
    index, subindex = entry.address
    if subindex == 0 and f"{index:04X}sub0" not in known:
        return f"{index:04X}"
    return f"{index:04X}sub{subindex:X}"


def _described(variable: ODVariable) -> dict[str, str]:
    """The keys of an entry that the EDS does not have."""
    return {
        "ParameterName": variable.name,
        "ObjectType": VARIABLE,
        "DataType": f"0x{variable.data_type:04X}",
        "AccessType": variable.access_type,
        "PDOMapping": str(int(variable.pdo_mappable)),
    }


def _changed(entry: Entry) -> Iterator[tuple[str, str]]:
    """What is not as the EDS says: limits, and the value of a parameter."""
    variable = entry.variable
    if variable.max is not None:
        yield "HighLimit", str(variable.max)
    value = entry.unpack(entry.read())
    if _is_parameter(variable) and value != (variable.default or type(value)()):
        yield "ParameterValue", f"0x{value:X}" if isinstance(value, int) else value


def _is_parameter(variable: ODVariable) -> bool:
    """Whether its value says how the device is set up: how many entries there are does."""
    of_record = variable.subindex == 0 and not isinstance(variable.parent, ObjectDictionary)
    return of_record or (variable.index in COMMUNICATION_AREA and variable.index not in ERRORS)


def _records(slave: Slave, sections: Sections) -> Iterator[tuple[str, int]]:
    for index, subs in slave.entries.items():
        if "SubNumber" in sections[f"{index:04X}"]:
            yield f"{index:04X}", len(subs)


def _in_order(sections: Sections) -> Sections:
    """Every entry behind the one before it, everything else where it was."""
    places = {name: place for place, name in enumerate(sections)}

    def place(name: str) -> tuple[int, int]:
        entry = ENTRY.fullmatch(name)
        return (places[entry[1]], int(entry[2], 16) + 1) if entry else (places[name], 0)

    return {name: sections[name] for name in sorted(sections, key=place)}


def _text(sections: Sections) -> str:
    parser = _parser()
    parser.read_dict(sections)
    text = StringIO()
    parser.write(text, space_around_delimiters=False)
    return text.getvalue().rstrip("\n") + "\n"
