"""Objects as a scenario names them: "Run command", "Record.Entry", 0x2014 or 0x1800:2."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import VISIBLE_STRING

from simulators.errors import unknown
from simulators.objects import Address
from simulators.replay.document import Item

ADDRESS = re.compile(r"0x([0-9A-Fa-f]{1,4})(?::(0x[0-9A-Fa-f]{1,2}|0?[0-9]|[1-9][0-9]{1,2}))?")
HIGHEST_SUBINDEX = 0xFF


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
        address = _address(item)
        text = item.text if address is None else _text(address, ":" in item.text)
        if text not in self._known:
            raise unknown("object", item.text, self._known)
        variable = self._known[text]
        return Target(item.text, (variable.index, variable.subindex), variable)

    def find_any(self, item: Item) -> Target:
        """The same; an address may also lead nowhere, for a master that shall be refused.

        Raises:
            UserError: no object has this name.
        """
        address = _address(item)
        if address is None:
            return self.find(item)
        return Target(item.text, address, self._known.get(_text(address, True)))


def _named(od: ObjectDictionary) -> Iterator[tuple[str, ODVariable]]:
    for name, item in od.names.items():
        if isinstance(item, ODVariable):
            yield name, item
            yield _text((item.index, 0), False), item
            yield _text((item.index, 0), True), item
            continue
        for variable in item.subindices.values():
            yield f"{name}.{variable.name}", variable
            yield _text((variable.index, variable.subindex), True), variable


def _address(item: Item) -> Address | None:
    if not (match := ADDRESS.fullmatch(item.text)):
        return None
    index, subindex = match[1], match[2] or "0"
    number = int(subindex, 16 if subindex.startswith("0x") else 10)
    if number > HIGHEST_SUBINDEX:
        raise item.wrong(f"sub-index {number} is not in 0..{HIGHEST_SUBINDEX}")
    return int(index, 16), number


def _text(address: Address, with_subindex: bool) -> str:
    index, subindex = address
    return f"0x{index:04X}:{subindex}" if with_subindex else f"0x{index:04X}"
