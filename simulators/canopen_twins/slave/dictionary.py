"""The object dictionary of an EDS file, for the node id it is wanted for, and its names."""

import pickle
import re
from collections.abc import Iterator
from functools import cache
from typing import Any

from canopen import ObjectDictionary, import_od
from canopen.objectdictionary import ODVariable

from canopen_twins.bus.sdo import Address
from canopen_twins.files.shipped import od_file

NUMBERS = ("default", "value")  # of a variable; beside each is its text, such as `default_raw`
DUMMIES = range(0x0001, 0x0020)  # data types that fill gaps of a mapping, no objects (CiA 301)


@cache
def _imported(eds: str) -> bytes:
    """Import once a file: its dictionary for node id 0, and the numbers that count from there.

    Unpickling is twenty times as fast.
    """
    with od_file(eds) as path:
        od = import_od(str(path), node_id=0)
    items = od.indices.values()
    entries = [each for item in items for each in variables(item).values()]
    relative = [(each, key) for each in entries for key in NUMBERS if _is_relative(each, key)]
    return pickle.dumps((od, relative))


def variables(item: Any) -> dict[int, ODVariable]:
    """The entries of an object of canopen by sub-index, whatever kind of object it is."""
    return {0: item} if isinstance(item, ODVariable) else item.subindices


def _is_relative(variable: ODVariable, key: str) -> bool:
    text = getattr(variable, f"{key}_raw", "").replace(" ", "").upper()
    return "$NODEID" in text and isinstance(getattr(variable, key), int)


def dictionary(eds: str, node_id: int) -> ObjectDictionary:
    """A fresh object dictionary from a file of od/ (or a path), with `$NODEID` filled in."""
    od: ObjectDictionary
    od, relative = pickle.loads(_imported(eds))
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
        for variable in variables(item).values():
            yield variable.qualname, variable
