"""Objects as a scenario names them: "Run command", "Record.Entry", 0x2014 or 0x1003:0A."""

from dataclasses import dataclass

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import VISIBLE_STRING

from canopen_twins.errors import UserError
from canopen_twins.slave.dictionary import Objects, address_text, parse_address
from canopen_twins.slave.object import Address


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
        self._objects = Objects(od)

    def find(self, text: str) -> Target:
        """An object that is there.

        Raises:
            UserError: it is not, or several have this name.
        """
        variable = self._objects.find(text)
        return Target(text, (variable.index, variable.subindex), variable)

    def find_any(self, text: str) -> Target:
        """The same; an address may also lead nowhere, for a master that shall be refused.

        Raises:
            UserError: no object has this name.
        """
        if not (parsed := parse_address(text)):
            return self.find(text)
        address = parsed[0], parsed[1] or 0
        return Target(text, address, self._objects.get(address_text(address)))

    def find_readable(self, text: str) -> Target:
        """The same; raises also if the EDS lets nobody read it."""
        target = self.find(text)
        if target.variable is not None and not target.variable.readable:
            raise UserError(
                f"{target.variable.name!r} is write only; "
                "if that is the point, put abort: 0x06010001 beside"
            )
        return target
