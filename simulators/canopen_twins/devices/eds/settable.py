"""Objects that are set by hand: a twin measures what somebody says is there to be measured."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import (
    BOOLEAN,
    FLOAT_TYPES,
    INTEGER_TYPES,
    SIGNED_TYPES,
    VISIBLE_STRING,
)

from canopen_twins.device.device import Device
from canopen_twins.errors import UserError, unknown
from canopen_twins.files.convert import convert
from canopen_twins.slave.dictionary import address_text, entries
from canopen_twins.slave.object import Address, Rejected
from canopen_twins.slave.service import Service
from canopen_twins.slave.slave import Slave


class Objects(Mapping[str, ODVariable]):
    """The entries of a dictionary by their names and by their addresses."""

    def __init__(self, od: ObjectDictionary) -> None:
        self._known = dict(_named(od))

    def __getitem__(self, name: str) -> ODVariable:
        if name.startswith("0x"):
            name = f"0x{name[2:].upper()}"
        if name not in self._known:
            raise unknown("object", name, self._known)
        return self._known[name]

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and f"{name[:2]}{name[2:].upper()}" in self._known

    def __iter__(self) -> Iterator[str]:
        return iter(self._known)

    def __len__(self) -> int:
        return len(self._known)


def _named(od: ObjectDictionary) -> Iterator[tuple[str, ODVariable]]:
    for name, variable in entries(od):
        yield name, variable
        if variable.parent is od:
            yield f"0x{variable.index:04X}", variable
        yield address_text((variable.index, variable.subindex)), variable
