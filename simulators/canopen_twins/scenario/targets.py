"""Objects as a scenario names them: "Run command", "Record.Entry", 0x2014 or 0x1003:0A."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import VISIBLE_STRING

from canopen_twins.errors import UserError, unknown
from canopen_twins.files.document import Item
from canopen_twins.slave.object import Address

ADDRESS = re.compile(r"0x([0-9A-Fa-f]{4})(?::([0-9A-Fa-f]{2}))?")


@dataclass(frozen=True)
class Target:
    """An object that a scenario reads or writes."""

    name: str
    """As the scenario names it."""
    address: Address
    variable: ODVariable | None = None
    """None if the dictionary has no such object."""

    @property
    def is_text(self) -> bool:
        """Whether its values are texts; all others are numbers to a scenario."""
        return self.variable is not None and self.variable.data_type == VISIBLE_STRING

    def __str__(self) -> str:
        return self.name


class Targets:
    """The objects of one dictionary."""

    def __init__(self, od: ObjectDictionary) -> None:
        self._known = dict(_named(od))

    def find(self, item: Item) -> Target:
        """An object that is there.

        Raises:
            UserError: it is not.
        """
        return self.named(item.text)

    def named(self, text: str) -> Target:
        """The same for a text that is in no file; raises as `find` does."""
        name = self._text(text) if text.startswith("0x") else text
        if name not in self._known:
            raise unknown("object", name, self._known)
        variable = self._known[name]
        return Target(text, (variable.index, variable.subindex), variable)

    def find_any(self, item: Item) -> Target:
        """The same; an address may also lead nowhere, for a master that shall be refused.

        Raises:
            UserError: no object has this name.
        """
        if not (match := ADDRESS.fullmatch(item.text)):
            return self.find(item)
        address = int(match[1], 16), int(match[2] or "0", 16)
        return Target(item.text, address, self._known.get(_text(*address)))

    def _text(self, address: str) -> str:
        if not ADDRESS.fullmatch(address):
            raise UserError(f"{address!r} is no address; addresses look like 0x2014 or 0x1003:0A")
        text = f"0x{address[2:].upper()}"
        if f"{text}:00" in self._known and text not in self._known:
            raise UserError(f"{text} is a record: say which entry of it, such as {text}:01")
        return text


def _named(od: ObjectDictionary) -> Iterator[tuple[str, ODVariable]]:
    for name, item in od.names.items():
        if isinstance(item, ODVariable):
            yield name, item
            yield f"0x{item.index:04X}", item
            yield _text(item.index, 0), item
        else:
            for variable in item.subindices.values():
                yield f"{name}.{variable.name}", variable
                yield _text(variable.index, variable.subindex), variable


def _text(index: int, subindex: int) -> str:
    return f"0x{index:04X}:{subindex:02X}"
