"""The object dictionary of a file, for the node id it is wanted for, and its names."""

import pickle
import re
from collections.abc import Iterator, Sequence
from functools import cache

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable

from canopen_twins.bus.sdo import Address
from canopen_twins.files.shipped import od_file
from canopen_twins.slave.eds.reader import Eds, entries_of, read_eds


def read(eds: str, modules: Sequence[int] | None = None) -> Eds:
    """Read a file of od/, or a path.

    Raises:
        UserError: it cannot be read, or describes no dictionary.
    """
    with od_file(eds) as path:
        return read_eds(path, modules)


@cache
def _imported(eds: str, modules: tuple[int, ...] | None, _: int) -> bytes:
    """Read once a file. Unpickling is twenty times as fast."""
    file = read(eds, modules)
    return pickle.dumps((file.dictionary, file.relative))


def dictionary(
    eds: str, node_id: int, modules: Sequence[int] | None = None, version: int = 0
) -> ObjectDictionary:
    """A fresh object dictionary from a file of od/ (or a path), with `$NODEID` filled in.

    A file is read once: whoever knows that it may have changed names another `version`.

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
    for item in od.names.values():
        for variable in entries_of(item).values():
            yield variable.qualname, variable
