"""Objects that somebody sets, as settings are: a device measures what is around it."""

from collections.abc import Iterable, Mapping
from dataclasses import fields
from sys import float_info
from typing import Any

from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import (
    BOOLEAN,
    FLOAT_TYPES,
    INTEGER_TYPES,
    REAL32,
    REAL64,
    SIGNED_TYPES,
    VISIBLE_STRING,
)

from canopen_twins.device.device import Device
from canopen_twins.errors import UserError, unknown
from canopen_twins.files.convert import convert
from canopen_twins.slave.dictionary import Objects, address_text
from canopen_twins.slave.object import Address, Entry, Rejected, Value
from canopen_twins.slave.service import Service
from canopen_twins.slave.slave import Slave

LARGEST = {REAL32: 3.4028234e38, REAL64: float_info.max}


class Settable(Device):
    """`set` takes objects by their names or addresses, too; a setting of that name comes first.

    What only the device can write stays through resets and without power, as settings do.
    """

    slave: Slave | None = None
    """The dictionary in force, or the last one there was."""

    def __init__(self, **given: object) -> None:
        self._put: dict[Address, bytes] = {}
        super().__init__(**given)

    def services(self, slave: Slave) -> Iterable[Service]:
        """Those there are; what has been set is in the memory before they begin."""
        self.slave = slave
        for (index, subindex), data in self._put.items():
            slave.data_store[index][subindex] = data
        yield from super().services(slave)

    @property
    def ranges(self) -> Mapping[str, tuple[int, int]]:
        """Of what nothing in the device says: by its limits, or all that its type has room for."""
        names = Objects(self.dictionary())
        found = {}
        for address in self.measured:
            variable = names[address_text(address)]
            if address in self.objects or variable.data_type not in INTEGER_TYPES:
                continue
            least, greatest = bounds(variable) or (0, 0)
            low = least if variable.min is None else variable.min
            high = greatest if variable.max is None else variable.max
            several = names.is_of_several(variable.qualname)
            name = address_text(address) if several else variable.qualname
            found[name] = (int(low), int(high))
        return found

    def knows(self, name: str) -> bool:
        """Whether `set` takes something of this name."""
        return super().knows(name) or name in Objects(self.dictionary())

    def current(self, name: str) -> Any:
        """Of an object, what is in the memory."""
        if super().knows(name):
            return super().current(name)
        variable, slave = Objects(self.dictionary()).find(name), self._booted
        entry = slave.entry(variable.index, variable.subindex)
        return entry.unpack(slave.data_store[variable.index][variable.subindex])

    def set_back(self, /, **before: object) -> None:
        """An object that takes its value no more, as one beyond its limits, has it all the same."""
        settings = {field.name for field in fields(self.settings)}
        self.set(**{name: value for name, value in before.items() if name in settings})
        for name, value in before.items():
            if name in settings:
                continue
            try:
                self.set(**{name: value})
            except UserError:
                variable = Objects(self.dictionary()).find(name)
                data = packed(variable, value_for(variable, value))
                self._booted.data_store[variable.index][variable.subindex] = data

    @property
    def _booted(self) -> Slave:
        assert self.slave is not None  # nobody asks before the first boot
        return self.slave

    def set(self, /, **given: object) -> None:
        """Change settings and objects while the device runs.

        Raises:
            UserError: neither is called so, or several objects are; a value of another type or out
                of range; an object has its value from a service of the node, or takes none now.
        """
        settings = {field.name for field in fields(self.settings)}
        chosen = {name: value for name, value in given.items() if name in settings}
        objects: list[tuple[ODVariable, Value]] = []
        if len(chosen) < len(given):
            known = Objects(self.dictionary())
            for name in (name for name in given if name not in settings):
                if name not in known and not name.startswith("0x"):
                    raise unknown("setting or object", name, {*settings, *known})
                variable = known.find(name)
                objects.append((variable, value_for(variable, given[name])))
        with self._trial(chosen, live=True):
            for variable, value in objects:
                self.put(variable, value)
            self.apply()

    def put(self, variable: ODVariable, value: Value) -> None:
        """Let an object have a value that it can have; raises as `set` does."""
        address = variable.index, variable.subindex
        data = packed(variable, value)
        if self.slave is not None:  # it has booted
            self._write(self.slave, self.slave.entry(*address), data)
        if not variable.writable:
            self._put[address] = data

    def _write(self, slave: Slave, entry: Entry, data: bytes) -> None:
        index, subindex = entry.address
        what = f"object {entry.variable.qualname!r}"
        if entry.writable:
            try:
                slave.write(entry, data)
            except Rejected as refusal:
                raise UserError(f"{what} does not take that: {refusal}") from None
        else:
            slave.data_store[index][subindex] = data
        if entry.address in self.measured and entry.address not in self.objects:
            return  # it may be shown later, and with noise
        if entry.readable and entry.read() != data:
            raise UserError(f"{what} ({address_text(entry.address)}) is what the node says")


def bounds(variable: ODVariable) -> tuple[float, float] | None:
    """The least and the greatest number that a type has room for; none if it is no number."""
    data_type = variable.data_type
    if data_type == BOOLEAN:
        return 0, 1
    if data_type in FLOAT_TYPES:
        return -LARGEST[data_type], LARGEST[data_type]
    if data_type not in INTEGER_TYPES:
        return None
    bits = len(variable)
    signed = data_type in SIGNED_TYPES
    return (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)


def value_for(variable: ODVariable, given: object) -> Value:
    """A value as the type of an object has it.

    Raises:
        UserError: it is of another type, or has no room in it.
    """
    what = f"object {variable.qualname!r}"
    if variable.data_type == VISIBLE_STRING:
        text = str(convert(what, given, str))
        if not text.isascii():
            raise UserError(f"{what} has ASCII characters only, not {text!r}")
        return text
    if (ends := bounds(variable)) is None:
        raise UserError(f"{what} is neither a number nor a text: it cannot be set")
    kind = float if variable.data_type in FLOAT_TYPES else int
    number = convert(what, int(given) if isinstance(given, bool) else given, kind)
    assert isinstance(number, (int, float))
    if not ends[0] <= number <= ends[1]:
        raise UserError(f"{what} has room for {ends[0]}..{ends[1]}, not for {number}")
    return number


def packed(variable: ODVariable, value: Value) -> bytes:
    """A value that fits, as it goes over the wire."""
    if isinstance(value, str):
        return value.encode("ascii")
    data: bytes = ODVariable.STRUCT_TYPES[variable.data_type or 0].pack(value)
    return data
