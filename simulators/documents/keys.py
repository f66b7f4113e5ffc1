"""Keys of a table and what stands behind them, for files that need no JSON Schema."""

from collections.abc import Callable, Collection, Mapping
from typing import Any

from simulators.documents.document import Item
from simulators.documents.problems import Noted
from simulators.errors import UserError, unknown


def values(
    table: Item, known: Mapping[str, Callable[[Item], Any]], optional: Collection[str] = ()
) -> dict[str, Any]:
    """What stands behind the keys; notes as problems which are unknown, missing or wrong.

    Args:
        table: Keys with their values.
        known: Takes what stands behind each of the keys there may be; may raise `UserError`.
        optional: Those that may be left out.

    Raises:
        Noted: something was wrong.
    """
    taken = {}
    for name, pair in table.pairs.items():
        with table.problems.at(pair.place(known)):
            if name not in known:
                raise unknown("key", name, known)
            taken[name] = known[name](pair.value)
    missing = [name for name in known if name not in {*table.pairs, *optional}]
    with table.problems.at(table):
        if missing:
            verb = "is" if len(missing) == 1 else "are"
            raise UserError(f"{', '.join(map(repr, missing))} {verb} missing")
    if missing or len(taken) < len(table.pairs):
        raise Noted
    return taken
