"""What a file says: a dictionary of canopen, and remarks with their lines."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable

from canopen_twins.files.sections import Field, Remark, Section
from canopen_twins.slave.eds import values


class Dictionary(ObjectDictionary):
    """A name that several objects have stands for none of them."""

    def __init__(self) -> None:
        super().__init__()  # type: ignore[no-untyped-call]
        self.ambiguous: dict[str, list[int]] = {}
        """The indices behind such a name."""

    def add_object(self, item: Any) -> None:
        """Add an object, by its index and by its name."""
        other = self.names.get(item.name)
        super().add_object(item)
        if other is not None and other.index != item.index:
            self.ambiguous.setdefault(item.name, [other.index]).append(item.index)

    def __getitem__(self, key: int | str) -> Any:
        if key in self.ambiguous:
            indices = " and ".join(f"0x{index:04X}" for index in self.ambiguous[str(key)])
            raise KeyError(f"{key!r} is the name of {indices}: say which by its index")
        return super().__getitem__(key)


@dataclass
class Eds:
    """What a file says."""

    dictionary: Dictionary
    """For node id 0."""
    relative: list[tuple[ODVariable, str]] = field(default_factory=list)
    """Variables with the attributes to which the node id has to be added."""
    remarks: list[Remark] = field(default_factory=list)
    """What is wrong or unusual in it, in the order of its lines."""
    node_id: int | None = None
    """That of a DCF: 1..127, or 255 for a node that has none yet."""
    node_name: str = ""
    files: list[Path] = field(default_factory=list)
    """Those beside it whose content objects have."""

    def remark(self, section: Section, words: str, at: Field | None = None) -> None:
        """Keep what is wrong with a section, or with one of its fields."""
        line = section.line if at is None else at.line
        self.remarks.append(Remark(line, section.name, words))

    def count(self, section: Section, key: str) -> int | None:
        """A number that is no value of an object; none if there is none, or it is none."""
        text = section.text(key)
        if not text:
            if key in section:
                self.remark(section, f"{key} is empty: as if it were not there", section[key])
            return None
        try:
            found = values.count(text)
        except ValueError as failure:
            self.remark(section, f"{key}: {failure}: ignored", section[key])
            return None
        if found.doubt:
            self.remark(section, f"{key}: {found.doubt}", section[key])
        return int(found.value)
