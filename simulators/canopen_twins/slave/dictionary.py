"""The object dictionary of a file, for the node id it is wanted for, and its names."""

import pickle
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache, lru_cache
from typing import TYPE_CHECKING, TypeVar

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable

from canopen_twins.bus.sdo import Address
from canopen_twins.errors import UserError, unknown
from canopen_twins.files.shipped import od_file
from canopen_twins.slave.object import entries_of

if TYPE_CHECKING:
    from canopen_twins.slave.eds.eds import Eds


@lru_cache(maxsize=1)  # whoever looks at a file makes twins of it next
def read(eds: str, modules: tuple[int, ...] | None = None, version: int = 0) -> "Eds":
    """Read a file of od/, or a path; nobody changes what is returned.

    A file is read once: whoever knows that it may have changed names another `version`.

    Raises:
        UserError: it cannot be read, or describes no dictionary.
    """
    from canopen_twins.slave.eds.reader import read_eds  # noqa: PLC0415 - the import takes 15 ms

    with od_file(eds) as path:
        return read_eds(path, modules)


@cache
def _imported(eds: str, modules: tuple[int, ...] | None, version: int) -> bytes:
    """Unpickling is twenty times as fast as reading."""
    file = read(eds, modules, version)
    return pickle.dumps((file.dictionary, file.relative))


def dictionary(
    eds: str, node_id: int, modules: Sequence[int] | None = None, version: int = 0
) -> ObjectDictionary:
    """A fresh object dictionary from a file of od/ (or a path), with `$NODEID` filled in.

    Its `version` is that of `read`.

    Raises:
        UserError: the file cannot be read, or describes no dictionary.
    """
    od: ObjectDictionary
    plugged = None if modules is None else tuple(modules)
    od, relative = pickle.loads(_imported(eds, plugged, version))
    for variable, key in relative:
        setattr(variable, key, getattr(variable, key) + node_id)
    if od.node_id is not None:
        od.node_id = node_id
    return od


ADDRESS = re.compile(r"0x([0-9A-Fa-f]{4})(?::([0-9A-Fa-f]{2}))?")


def parse_address(text: str) -> tuple[int, int | None] | None:
    """Index and sub-index of 0x1003:0A, no sub-index of 0x2014; none if the text is no address."""
    if not (match := ADDRESS.fullmatch(text)):
        return None
    return int(match[1], 16), int(match[2], 16) if match[2] else None


def address_text(address: Address) -> str:
    """An address as users write it: 0x1003:0A."""
    return f"0x{address[0]:04X}:{address[1]:02X}"


def entries(od: ObjectDictionary) -> Iterator[tuple[str, ODVariable]]:
    """Every entry with the name that users call it by: Run command, or Record.Entry."""
    for item in od.indices.values():
        for variable in entries_of(item).values():
            yield variable.qualname, variable


Item = TypeVar("Item")


class Names(Mapping[str, Item]):
    """What names stand for; one that several have stands for none of them, and says so.

    Looking it up raises `UserError`.
    """

    def __init__(self, named: Iterable[tuple[str, Address, Item]]) -> None:
        self._items: dict[str, Item] = {}
        self._addresses: dict[str, dict[Address, None]] = {}
        for name, address, item in named:
            self._items[name] = item
            self._addresses.setdefault(name, {})[address] = None

    def is_of_several(self, name: str) -> bool:
        """Whether a name says not enough."""
        return len(self._addresses[name]) > 1

    def __getitem__(self, name: str) -> Item:
        if name in self._items and self.is_of_several(name):
            first, second, *more = map(address_text, self._addresses[name])
            others = f" and {len(more)} more" if more else ""
            raise UserError(
                f"{name!r} is the name of {first} and {second}{others}: say which by its address"
            )
        return self._items[name]

    def __contains__(self, name: object) -> bool:
        return name in self._items

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)


class Objects(Names[ODVariable]):
    """The entries of a dictionary by names and by addresses: 0x2014 or 0x1003:0A."""

    def __init__(self, od: ObjectDictionary) -> None:
        super().__init__(_named(od))

    def find(self, text: str) -> ODVariable:
        """An entry that is there.

        Raises:
            UserError: it is not, or several have this name.
        """
        name = self._address(text) if text.startswith("0x") else text
        if name not in self:
            raise unknown("object", name, self)
        return self[name]

    def _address(self, text: str) -> str:
        if not parse_address(text):
            raise UserError(f"{text!r} is no address; addresses look like 0x2014 or 0x1003:0A")
        text = f"0x{text[2:].upper()}"
        if f"{text}:00" in self and text not in self:
            raise UserError(f"{text} is a record: say which entry of it, such as {text}:01")
        return text


def _named(od: ObjectDictionary) -> Iterator[tuple[str, Address, ODVariable]]:
    for name, variable in entries(od):
        address = variable.index, variable.subindex
        yield name, address, variable
        if variable.parent is od:
            yield f"0x{variable.index:04X}", address, variable
        yield address_text(address), address, variable
