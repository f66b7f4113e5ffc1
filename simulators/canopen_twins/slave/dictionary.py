"""The object dictionary of a file, for the node id it is wanted for."""

import pickle
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from canopen import ObjectDictionary

from canopen_twins.files.shipped import od_file
from canopen_twins.slave.eds.reader import DUMMY_TYPES as DUMMIES
from canopen_twins.slave.eds.reader import Eds, read_eds
from canopen_twins.slave.eds.reader import entries_of as variables

__all__ = ["DUMMIES", "dictionary", "read", "variables"]


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


def dictionary(eds: str, node_id: int, modules: Sequence[int] | None = None) -> ObjectDictionary:
    """A fresh object dictionary from a file of od/ (or a path), with `$NODEID` filled in.

    Raises:
        UserError: the file cannot be read, or describes no dictionary.
    """
    path = Path(eds)
    changed = path.stat().st_mtime_ns if path.is_absolute() and path.exists() else 0
    od: ObjectDictionary
    od, relative = pickle.loads(
        _imported(eds, None if modules is None else tuple(modules), changed)
    )
    for variable, key in relative:
        setattr(variable, key, getattr(variable, key) + node_id)
    if od.node_id is not None:
        od.node_id = node_id
    return od
