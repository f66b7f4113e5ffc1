"""Objects that an EDS file tells in short: compact PDOs (CiA 306, 4.6.3.4.1) and modules (6).

Each becomes the sections that would have stood there, so that whoever reads objects need not know.
A section that is there already holds.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from canopen.objectdictionary import ODVariable

from canopen_twins.files.sections import Section, Sections
from canopen_twins.slave.eds import values

ARRAY, RECORD, VAR = "0x8", "0x9", "0x7"
UNSIGNED8, UNSIGNED16, UNSIGNED32 = "0x0005", "0x0006", "0x0007"
HIGHEST_SUB = 0xFE
MOST_PDOS = 512
MOST_PARTS = 64  # of a mapping
PREDEFINED = 4  # PDOs with an identifier of their own (CiA 301, 7.3.3)
NO_PDO = "0x80000000"
MOST_MODULES = 254
MAPPING = 0x200  # from the communication record of a PDO to its mapping
BITS = re.compile(r"0\s*;\s*([0-9]+)")
COMMUNICATION = {  # sub-index: name, data type, default
    1: ("COB-ID", UNSIGNED32, ""),
    2: ("Transmission type", "0x0005", "255"),
    3: ("Inhibit time", UNSIGNED16, "0"),
    4: ("Reserved", "0x0005", "0"),
    5: ("Event timer", UNSIGNED16, "0"),
    6: ("SYNC start value", "0x0005", "0"),
}


def number(section: Section, key: str, otherwise: int = 0) -> int:
    """A count; `otherwise` if it is not there or none."""
    try:
        return int(values.count(section.text(key)).value)
    except ValueError:
        return otherwise


def add_compact_pdos(sections: Sections) -> None:
    """PDOs that are counted in DeviceInfo and have no section, if CompactPDO says which entries."""
    information = sections.section("DeviceInfo")
    mask = number(information, "CompactPDO")
    if not mask:
        return
    entries = [sub for sub in COMMUNICATION if mask >> sub - 1 & 1]
    for key, first, identifier in (("NrOfRXPDO", 0x1400, 0x200), ("NrOfTXPDO", 0x1800, 0x180)):
        wanted = min(number(information, key), MOST_PDOS)
        there = sum(f"{first + pdo:04X}" in sections for pdo in range(MOST_PDOS))
        free = (pdo for pdo in range(MOST_PDOS) if f"{first + pdo:04X}" not in sections)
        for _, pdo in zip(range(wanted - there), free, strict=False):
            cob_id = f"$NODEID+0x{identifier + 0x100 * pdo:X}" if pdo < PREDEFINED else NO_PDO
            sections.add(_communication(first + pdo, entries, cob_id, information.line))
            sections.add(_mapping(first + pdo + MAPPING, information.line))


def _communication(index: int, entries: Sequence[int], cob_id: str, line: int) -> Iterator[Section]:
    yield _record(index, f"PDO communication parameter 0x{index:04X}", RECORD, line)
    yield _entry(index, 0, line, ("Highest sub-index", UNSIGNED8, str(max(entries))), "const")
    for sub in entries:
        name, data_type, default = COMMUNICATION[sub]
        yield _entry(index, sub, line, (name, data_type, default or cob_id))


def _mapping(index: int, line: int) -> Iterator[Section]:
    yield _record(index, f"PDO mapping parameter 0x{index:04X}", RECORD, line)
    yield _entry(index, 0, line, ("Number of mapped objects", UNSIGNED8, "0"))
    for sub in range(1, 65):
        yield _entry(index, sub, line, (f"Mapped object {sub}", UNSIGNED32, "0"))


def _record(index: int, name: str, kind: str, line: int) -> Section:
    return Section.of(f"{index:04X}", line, {"ParameterName": name, "ObjectType": kind})


def _entry(
    index: int, sub: int, line: int, what: tuple[str, str, str], access: str = "rw"
) -> Section:
    name, data_type, default = what
    keys = {"ParameterName": name, "ObjectType": VAR, "DataType": data_type}
    keys |= {"AccessType": access, "DefaultValue": default, "PDOMapping": "0"}
    return Section.of(f"{index:04X}sub{sub:X}", line, keys)


def add_modules(sections: Sections, modules: Sequence[int] | None) -> None:
    """The objects of the modules that are plugged into a coupler.

    Args:
        sections: Of the coupler's file.
        modules: Their numbers in it, in their order; none for those that a DCF lists.
    """
    supported = number(sections.section("SupportedModules"), "NrOfEntries")
    if not supported:
        return
    place = sections.section("SupportedModules")
    plugged = _connected(sections) if modules is None else list(modules)
    if not plugged:
        words = "is a modular coupler: without the setting modules=1,1,2 no module is plugged in"
        sections.remark(place, words)
    rack = Rack(sections)
    for module in plugged[:MOST_MODULES]:
        if 1 <= module <= supported:
            rack.plug(module)
        else:
            sections.remark(place, f"has no module {module}: there are 1 to {supported}")
    _shorten_mappings(sections)


def _connected(sections: Sections) -> list[int]:
    section = sections.section("ConnectedModules")
    count = min(number(section, "NrOfEntries"), MOST_MODULES)
    return [number(section, str(place)) for place in range(1, count + 1)]


@dataclass
class Growth:
    """How far modules have filled the arrays that begin at an index."""

    index: int
    sub: int
    bits: int = 0
    """Free ones of the last sub-index."""


class Rack:
    """Modules in their order: each adds its objects, and sub-indices to those of all."""

    def __init__(self, sections: Sections) -> None:
        self._sections = sections
        self._growths: dict[int, Growth] = {}

    def plug(self, module: int) -> None:
        """Add what a module brings."""
        prefix = f"M{module}"
        for index in self._listed(f"{prefix}FixedObjects"):
            self._add_fixed(f"{prefix}Fixed", index)
        for index in self._listed(f"{prefix}SubExtends"):
            self._extend(index, self._sections.section(f"{prefix}SubExt{index:X}"))

    def _listed(self, name: str) -> list[int]:
        section = self._sections.section(name)
        count = min(number(section, "NrOfEntries"), len(section))
        return [number(section, str(place)) for place in range(1, count + 1)]

    def _add_fixed(self, prefix: str, index: int) -> None:
        """There once, if at least one such module is."""
        found = re.compile(rf"{prefix}0*{index:X}(sub[0-9A-F]+)?", re.IGNORECASE)
        copies = []
        for section in self._sections.values():
            if match := found.fullmatch(section.name):
                copies.append(section.renamed(f"{index:04X}{match[1] or ''}"))
        self._sections.add(copies)

    def _extend(self, index: int, told: Section) -> None:
        """`Count=k` adds k sub-indices, `Count=0;b` adds b bits to one that others share."""
        growth = self._growths.setdefault(index, Growth(index, self._highest(index)))
        if match := BITS.fullmatch(told.text("Count")):
            width = _width(told)
            for _ in range(min(int(match[1]), width * HIGHEST_SUB)):
                if not growth.bits:
                    self._grow(growth, told)
                    growth.bits = width
                growth.bits -= 1
            return
        for _ in range(min(number(told, "Count", 1), MOST_MODULES)):
            self._grow(growth, told)

    def _highest(self, index: int) -> int:
        subs = (
            sub for sub in range(HIGHEST_SUB, 0, -1) if f"{index:04X}sub{sub:X}" in self._sections
        )
        return next(subs, 0)

    def _grow(self, growth: Growth, told: Section) -> None:
        last = number(told, "ObjExtend") or HIGHEST_SUB
        if growth.sub >= last:
            growth.index, growth.sub = growth.index + 1, 0
        growth.sub += 1
        index, sub, line = growth.index, growth.sub, told.line
        name = told.text("ParameterName", f"0x{index:04X}")
        self._sections.add(
            [
                _record(index, name, ARRAY, line),
                told.renamed(f"{index:04X}sub{sub:X}", {"ParameterName": f"{name} {sub}"}),
            ]
        )
        count = ("Number of entries", UNSIGNED8, str(sub))
        self._sections.put(_entry(index, 0, line, count, "ro"))
        self._sections[f"{index:04X}"].put("SubNumber", str(sub + 1), line)


def _width(told: Section) -> int:
    codec = ODVariable.STRUCT_TYPES.get(number(told, "DataType"))
    return codec.size * 8 if codec else 8


def _shorten_mappings(sections: Sections) -> None:
    """A mapping ends before the first object that is not plugged in (CiA 306, 6.2.2)."""
    for first in (0x1600, 0x1A00):
        for index in range(first, first + MOST_PDOS):
            if (count := sections.section(f"{index:04X}sub0")).text("DefaultValue"):
                _shorten(sections, index, count)


def _shorten(sections: Sections, index: int, count: Section) -> None:
    told = number(count, "DefaultValue")
    for sub in range(1, min(told, MOST_PARTS) + 1):
        mapped = number(sections.section(f"{index:04X}sub{sub:X}"), "DefaultValue")
        target = f"{mapped >> 16:04X}"
        entry = f"{target}sub{mapped >> 8 & 0xFF:X}"
        if mapped and entry not in sections and (mapped >> 8 & 0xFF or target not in sections):
            count.put("DefaultValue", str(sub - 1), count.line)
            if sub == 1:
                cob_id = sections.section(f"{index - MAPPING:04X}sub1")
                cob_id.put(
                    "DefaultValue", f"{cob_id.text('DefaultValue', '0')}+{NO_PDO}", count.line
                )
            return
