"""What is unusual in the dictionary of a file, once its objects are read: lists, identity, PDOs."""

import re
from collections.abc import Iterator

from canopen.objectdictionary import ODVariable

from canopen_twins.files.sections import Remark, Section, Sections
from canopen_twins.slave.eds import values

LISTS = ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects")
IDENTITY = {"VendorNumber": 1, "ProductNumber": 2, "RevisionNumber": 3}
RPDO, TPDO = range(0x1400, 0x1600), range(0x1800, 0x1A00)
MAPPING = 0x200  # from the communication record of a PDO to its mapping
LONGEST_PDO = 64  # bits
NUMBERED = re.compile("[0-9]{1,5}")
Objects = dict[int, Section]
Entries = dict[tuple[int, int], ODVariable]


def check(sections: Sections, objects: Objects, entries: Entries) -> Iterator[Remark]:
    """Remarks on a file; nothing is taken away or added because of them.

    Args:
        sections: Of the file.
        objects: The section of each object, by index.
        entries: What the dictionary has, by address.
    """
    yield from _lists(sections, objects)
    yield from _identity(sections, entries)
    for kind, pdos in (("RPDO", RPDO), ("TPDO", TPDO)):
        for index in pdos:
            if index in objects:
                yield from _pdo(f"{kind}{index - pdos.start + 1}", index, objects, entries)


def _lists(sections: Sections, objects: Objects) -> Iterator[Remark]:
    """Objects that are in no list, and those in one that are nowhere else."""
    listed: dict[int, Remark] = {}
    for section in map(sections.section, LISTS):
        for key in section:
            if NUMBERED.fullmatch(key) and (number := _number(section.text(key))) is not None:
                words = f"lists 0x{number:04X}, which is not there"
                listed[number] = Remark(section[key].line, section.name, words)
    yield from (remark for index, remark in listed.items() if index not in objects)
    if not listed:  # a file without lists is taken for what its sections say
        return
    for index, section in objects.items():
        if index >= 0x1000 and index not in listed:
            yield Remark(section.line, section.name, "is in no list of objects: it is there anyway")


def _identity(sections: Sections, entries: Entries) -> Iterator[Remark]:
    """DeviceInfo and the object 1018h say the same of the device; else the object holds."""
    information = sections.section("DeviceInfo")
    for key, subindex in IDENTITY.items():
        entry, said = entries.get((0x1018, subindex)), _number(information.text(key))
        if entry is None or not said or not isinstance(entry.default, int) or entry.default == said:
            continue
        words = f"{key} is {said:#x}, but 0x1018:{subindex:02X} is {entry.default:#x}: that holds"
        yield Remark(information[key].line, information.name, words)


def _pdo(name: str, index: int, objects: Objects, entries: Entries) -> Iterator[Remark]:
    section = objects.get(index + MAPPING)
    if section is None:
        words = f"{name} has no mapping 0x{index + MAPPING:04X}: there is no such PDO"
        yield Remark(objects[index].line, objects[index].name, words)
        return
    number = entries.get((index + MAPPING, 0))
    bits = 0
    for subindex in range(1, 1 + min(_value(number), LONGEST_PDO)):
        part = _value(entries.get((index + MAPPING, subindex)))
        target, length = (part >> 16, part >> 8 & 0xFF), part & 0x7F
        bits += length
        if part and target not in entries and not (target[0] < 0x20 and name.startswith("R")):
            words = f"{name} maps 0x{target[0]:04X}:{target[1]:02X}, which is not there"
            yield Remark(section.line, section.name, f"{words}: the PDO cannot become valid")
    if bits > LONGEST_PDO:
        words = f"{name} maps {bits} bits, but a frame has {LONGEST_PDO}"
        yield Remark(section.line, section.name, f"{words}: the PDO cannot become valid")


def _value(variable: ODVariable | None) -> int:
    found = None if variable is None else variable.default
    if variable is not None and variable.value is not None:
        found = variable.value
    return found if isinstance(found, int) else 0


def _number(text: str) -> int | None:
    try:
        return int(values.count(text).value) if text else None
    except ValueError:
        return None
