"""EDS and DCF files (CiA 306): their sections as an object dictionary of canopen.

Tools write what the standard does not know, and leave out what it demands. Whatever can only mean
one thing is taken. What cannot be used is a remark with its line, and the dictionary does without
that one entry; only a file without any object is refused.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from canopen.objectdictionary import ODArray, ODRecord, ODVariable
from canopen.objectdictionary.datatypes import DATA_TYPES, DOMAIN, UNSIGNED8

from canopen_twins.errors import UserError
from canopen_twins.files.sections import Field, Section, Sections, read_sections
from canopen_twins.slave.eds import values
from canopen_twins.slave.eds.check import MAPPING, RPDO, TPDO, check
from canopen_twins.slave.eds.eds import Dictionary, Eds
from canopen_twins.slave.eds.head import COMMISSIONING, read_head
from canopen_twins.slave.eds.short_forms import add_compact_pdos, add_modules
from canopen_twins.slave.object import DUMMY_TYPES, TIMES, entries_of

NULL, DOMAIN_OBJECT, DEFTYPE, DEFSTRUCT, VAR, ARRAY, RECORD = 0, 2, 5, 6, 7, 8, 9
SINGLE = (DOMAIN_OBJECT, DEFTYPE, VAR)
COMPOUND = (DEFSTRUCT, ARRAY, RECORD)
OBJECT = re.compile(r"(?:0[xX])?([0-9A-Fa-f]{1,4})(?:sub([0-9A-Fa-f]{1,2}))?", re.IGNORECASE)
LIST = re.compile(r"(?:0[xX])?([0-9A-Fa-f]{1,4})(Name|Value|Denotation)", re.IGNORECASE)
SUB = re.compile("[0-9]{1,3}")
KNOWN_TYPES = {*ODVariable.STRUCT_TYPES, *DATA_TYPES, *TIMES}
ACCESS = {"r": "ro", "w": "wo", "read": "ro", "write": "wo", "readonly": "ro", "read/write": "rw"}
KNOWN_ACCESS = ("ro", "wo", "rw", "rwr", "rww", "const")
LARGEST_DOMAIN = 1 << 24  # bytes
HIGHEST_SUB = 0xFE
LIMITS = {"LowLimit": "min", "HighLimit": "max"}
XML = (".xdd", ".xdc")  # CiA 311


def read_eds(path: Path, modules: Sequence[int] | None = None) -> Eds:
    """Read a file.

    Args:
        path: The file.
        modules: What is plugged into a modular coupler, by the numbers of its file; none for the
            modules that a DCF lists.

    Raises:
        UserError: it cannot be read, is no text, or describes no object.
    """
    sections = _read_xml(path) if path.suffix.lower() in XML else read_sections(path)
    add_compact_pdos(sections)
    add_modules(sections, modules)
    reader = EdsReader(sections, path)
    if not reader.objects:
        raise UserError(f"{path} is no EDS file: it has no object, such as [1000]")
    return reader.read()


def _read_xml(path: Path) -> Sections:
    from canopen_twins.slave.eds.xdd import read_xdd  # noqa: PLC0415 - few files are XML

    return read_xdd(path)


class EdsReader:
    """Reads sections once: makes an entry of each, or a remark."""

    def __init__(self, sections: Sections, path: Path) -> None:
        self._sections = sections
        self._path = path
        self.objects: dict[int, Section] = {}
        self._subs: dict[int, dict[int, Section]] = {}
        self._lists: dict[tuple[int, str], Section] = {}
        self._eds = Eds(Dictionary(), remarks=list(sections.remarks))
        self._sort()

    def read(self) -> Eds:
        """The whole file."""
        read_head(self._sections, self._eds)
        for index in sorted({*self.objects, *self._subs}):
            if index not in DUMMY_TYPES:
                self._read_object(index)
        self._number()
        self._eds.remarks += check(self._sections, self.objects, self._entries)
        self._leave_out_pdos_without_mapping()
        self._eds.remarks.sort(key=lambda remark: remark.line)
        return self._eds

    def _leave_out_pdos_without_mapping(self) -> None:
        """There is no such PDO; canopen looks for the mapping of every one there is."""
        objects, names = self._eds.dictionary.indices, self._eds.dictionary.names
        for index in (*RPDO, *TPDO):
            if index in objects and index + MAPPING not in objects:
                name = objects.pop(index).name
                if name in names and names[name].index == index:
                    del names[name]

    def _number(self) -> None:
        """LSS_SerialNumber of a DCF is that of 1018h:04 (CiA 306, 5.3.1)."""
        for name in COMMISSIONING:
            section = self._sections.section(name)
            number = self._eds.count(section, "LSS_SerialNumber")
            entry = self._entries.get((0x1018, 4))
            if number is None or entry is None:
                continue
            if 0 <= number < 1 << 32:
                entry.value = number
            else:
                words = f"LSS_SerialNumber {number} does not fit 32 bits: ignored"
                self._eds.remark(section, words, section["LSS_SerialNumber"])

    @property
    def _entries(self) -> dict[tuple[int, int], ODVariable]:
        return {
            (index, subindex): variable
            for index, item in self._eds.dictionary.indices.items()
            for subindex, variable in entries_of(item).items()
        }

    def _sort(self) -> None:
        for section in self._sections.values():
            if match := OBJECT.fullmatch(section.name):
                index, sub = int(match[1], 16), match[2]
                if section.name[:2] in {"0x", "0X"}:
                    self._eds.remark(section, "has 0x before the index: read without it")
                if sub is None:
                    self.objects[index] = section
                else:
                    self._subs.setdefault(index, {})[int(sub, 16)] = section
            elif match := LIST.fullmatch(section.name):
                self._lists[int(match[1], 16), match[2].lower()] = section

    # objects

    def _read_object(self, index: int) -> None:
        section = self.objects.get(index)
        subs = self._subs.get(index, {})
        if section is None:
            section = Section(f"{index:04X}", min(sub.line for sub in subs.values()))
            self._eds.remark(section, "is not there, but its sub-indices are: a record is made")
            kind = RECORD
        else:
            kind = self._object_type(section, bool(subs))
        item: Any = None
        if kind in SINGLE:
            item = self._variable(section, index, 0, domain=kind == DOMAIN_OBJECT)
        elif kind in COMPOUND:
            item = self._compound(section, index, kind, subs)
        if item is not None:
            self._eds.dictionary.add_object(item)

    def _object_type(self, section: Section, has_subs: bool) -> int:
        """What is not said is a variable, or a record if it has sub-indices."""
        otherwise = RECORD if has_subs else VAR
        kind = self._eds.count(section, "ObjectType")
        if kind is None:
            if has_subs:
                self._eds.remark(section, "has sub-indices but no ObjectType: a record")
            return otherwise
        if kind == NULL:
            self._eds.remark(section, "is of the object type NULL: left out")
        elif kind not in SINGLE + COMPOUND:
            self._eds.remark(section, f"there is no object type {kind}", section["ObjectType"])
            return otherwise
        elif kind in SINGLE and has_subs:
            self._eds.remark(section, "is a variable but has sub-indices: a record")
            return RECORD
        return kind

    def _compound(
        self, section: Section, index: int, kind: int, subs: Mapping[int, Section]
    ) -> Any:
        make: Any = ODArray if kind == ARRAY else ODRecord
        item = make(self._name(section, f"0x{index:04X}"), index)
        item.storage_location = section.text("StorageLocation") or None
        members = [*self._compact(section, index)]
        members += [self._variable(subs[subindex], index, subindex) for subindex in sorted(subs)]
        for variable in members:
            if variable is not None:
                item.add_member(variable)
        if 0 not in item.subindices:
            item.add_member(self._highest_sub(section, index, item.subindices))
        self._check_sub_number(section, item)
        return item

    def _highest_sub(self, section: Section, index: int, subs: Mapping[int, object]) -> ODVariable:
        self._eds.remark(section, "has no sub-index 0: it tells the highest there is")
        variable = ODVariable("Highest sub-index", index, 0)
        variable.data_type = UNSIGNED8
        variable.access_type = "ro"
        variable.default = max((sub for sub in subs if sub <= HIGHEST_SUB), default=0)
        return variable

    def _check_sub_number(self, section: Section, item: ODArray | ODRecord) -> None:
        """SubNumber counts the sub-indices there are, FFh left out (CiA 306, 4.6.3.2)."""
        if "SubNumber" not in section or self._compact_count(section):
            return
        said = self._eds.count(section, "SubNumber")
        there = sum(sub <= HIGHEST_SUB for sub in item.subindices)
        if said is not None and said != there:
            self._eds.remark(
                section, f"SubNumber is {said}, but there are {there}", section["SubNumber"]
            )

    def _compact_count(self, section: Section) -> int:
        number = self._eds.count(section, "CompactSubObj") if section.text("CompactSubObj") else 0
        return min(number or 0, HIGHEST_SUB)

    def _compact(self, section: Section, index: int) -> Iterator[ODVariable | None]:
        """CompactSubObj: so many sub-indices like their object (CiA 306, 4.6.3.4.2)."""
        number = self._compact_count(section)
        if not number:
            return
        names, own = self._list(index, "name"), self._list(index, "value")
        names |= self._list(index, "denotation")
        count = ODVariable("NrOfObjects", index, 0)
        count.data_type, count.access_type, count.default = UNSIGNED8, "ro", number
        if 0 in own:
            self._give(section, count, "default", own[0])
        yield count
        for subindex in range(1, number + 1):
            variable = self._variable(section, index, subindex)
            if variable is None:
                return
            name = names.get(subindex)
            variable.name = name.text if name else f"{variable.name}{subindex}"
            if subindex in own:
                self._give(section, variable, "value", own[subindex])
            yield variable

    def _list(self, index: int, kind: str) -> dict[int, Field]:
        """What a list such as [2100Name] says, by decimal sub-index; it may have gaps."""
        section = self._lists.get((index, kind))
        if section is None:
            return {}
        found = {
            int(key): section[key] for key in section if SUB.fullmatch(key) and section.text(key)
        }
        said = self._eds.count(section, "NrOfEntries")
        if said is not None and said != len(found):
            self._eds.remark(section, f"NrOfEntries is {said}, but there are {len(found)}")
        return {key: each for key, each in found.items() if key <= HIGHEST_SUB}

    def _name(self, section: Section, otherwise: str) -> str:
        for key in ("Denotation", "ParameterName"):
            if words := values.uncommented_words(section.text(key)):
                return words
        self._eds.remark(section, f"has no ParameterName: it is called {otherwise}")
        return otherwise

    def _variable(
        self, section: Section, index: int, subindex: int, domain: bool = False
    ) -> ODVariable | None:
        told = self._data_type(section, domain)
        if told is None:
            return None
        otherwise = f"0x{index:04X}:{subindex:02X}" if subindex else f"0x{index:04X}"
        variable: Any = ODVariable(self._name(section, otherwise), index, subindex)
        variable.storage_location = section.text("StorageLocation") or None
        variable.data_type = told if told in KNOWN_TYPES else DOMAIN
        variable.access_type = self._access(section, domain)
        if section.text("PDOMapping"):
            variable.pdo_mappable = bool(self._eds.count(section, "PDOMapping"))
        for key, name in (("DefaultValue", "default"), ("ParameterValue", "value")):
            if text := section.text(key):
                self._give(section, variable, name, section[key], told)
                setattr(variable, f"{name}_raw", text)
        if text := section.text("UploadFile"):
            self._serve(section, variable, re.split(r"[/\\]", values.uncommented_words(text))[-1])
        self._limit(section, variable)
        self._describe(section, variable)
        return cast(ODVariable, variable)

    def _serve(self, section: Section, variable: Any, name: str) -> None:
        """UploadFile: what the object has is the content of a file (CiA 306, 5.3.1)."""
        path = self._path.parent / name
        at = section["UploadFile"]
        if variable.data_type not in values.BYTES:
            self._eds.remark(section, "UploadFile is of a DOMAIN only: ignored", at)
            return
        try:
            with path.open("rb") as file:
                content: bytes | None = file.read(LARGEST_DOMAIN + 1)
        except (OSError, ValueError):
            content = None
        if content is None or len(content) > LARGEST_DOMAIN:
            told = "is not beside this file" if content is None else "is larger than 16 MiB"
            self._eds.remark(section, f"UploadFile {name!r} {told}: as if it were not said", at)
            return
        variable.value = content
        self._eds.files.append(path)

    def _data_type(self, section: Section, domain: bool) -> int | None:
        number = self._eds.count(section, "DataType")
        if number is None:
            if domain:
                return DOMAIN
            self._eds.remark(section, "has no DataType: left out")
            return None
        if number in KNOWN_TYPES:
            return number
        of_maker = self._sections.section(f"{number:X}sub1").text("DefaultValue")
        if of_maker:  # CanFestival's editor describes types with ranges so
            try:
                return int(values.count(of_maker).value)
            except ValueError:
                pass
        words = f"data type 0x{number:04X} is none of CiA 301: served as the bytes it has"
        self._eds.remark(section, words, section["DataType"])
        return number

    def _access(self, section: Section, domain: bool) -> str:
        word = values.uncommented(section.text("AccessType")).lower().strip("\"'")
        if word in KNOWN_ACCESS:
            return word
        if not word and domain:
            return "rw"
        access = ACCESS.get(word, "ro")
        told = f"AccessType {section.text('AccessType')!r} is" if word else "AccessType is missing:"
        self._eds.remark(section, f"{told} taken for {access}", section.get("AccessType"))
        return access

    def _give(
        self,
        section: Section,
        variable: Any,
        name: str,
        at: Field,
        data_type: int | None = None,
    ) -> None:
        """Set an attribute to the value that a field has; a remark if it has none."""
        try:
            found = values.value(at.text, data_type or variable.data_type)
        except ValueError as failure:
            self._eds.remark(section, f"{at.key}: {failure}: as if it were not there", at)
            return

        if found.doubt:
            self._eds.remark(section, f"{at.key}: {found.doubt}", at)
        setattr(variable, name, found.value)
        if found.relative:
            variable.relative = True
            self._eds.relative.append((variable, name))

    def _limit(self, section: Section, variable: ODVariable) -> None:
        """Limits that leave nothing to write are none: tools write 0 and 0 where nobody set any."""
        for key, name in LIMITS.items():
            if section.text(key):
                self._give(section, variable, name, section[key])
        low, high = variable.min, variable.max
        if low is None or high is None:
            return
        if low > high or (low == high and variable.writable):
            words = f"LowLimit {low} and HighLimit {high} leave nothing between them: no limits"
            self._eds.remark(section, words, section["LowLimit"])
            variable.min = variable.max = None
        elif isinstance(variable.default, int | float) and not low <= variable.default <= high:
            words = f"DefaultValue {variable.default} is not in {low}..{high}: it stays"
            self._eds.remark(section, words, section.get("DefaultValue"))

    def _describe(self, section: Section, variable: ODVariable) -> None:
        """Keys that canopen writes beside those of the standard."""
        variable.unit = section.text("Unit")
        if "Description" in section:
            variable.description = section["Description"].text
        if text := section.text("Factor"):
            try:
                variable.factor = float(text)
            except ValueError:
                self._eds.remark(
                    section, f"Factor {text!r} is no number: ignored", section["Factor"]
                )
