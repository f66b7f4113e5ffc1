"""What pydantic has found wrong with a value, in our words and with its place."""

from collections.abc import Callable, Collection, Mapping

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from simulators.documents.document import Item
from simulators.errors import UserError, unknown


def note(item: Item, failure: ValidationError, known: Collection[str] = ()) -> set[object]:
    """Note as problems what is wrong with a value; the keys behind which it is.

    Where it is a table, `known` are its keys.
    """
    wrong: set[object] = set()
    for error in failure.errors(include_url=False, include_input=False):
        with item.problems.at(_place(item, error, known)):
            raise TOLD[error["type"]](error, known)
        wrong.update(error["loc"][:1])
    return wrong


def _place(item: Item, error: ErrorDetails, known: Collection[str]) -> Item:
    key, *_ = error["loc"] or (None,)
    if key is None or key not in item.pairs:
        return item
    return item.pairs[str(key)].place(known)


def _own(error: ErrorDetails, known: Collection[str]) -> UserError:
    refusal: UserError = error["ctx"]["error"]
    return refusal


TOLD: Mapping[str, Callable[[ErrorDetails, Collection[str]], UserError]] = {
    "value_error": _own,
    "extra_forbidden": lambda error, known: unknown("key", error["loc"][0], known),
    "missing": lambda error, _: UserError(f"{error['loc'][0]!r} is missing"),
    "too_short": lambda *_: UserError("empty; at least one key with a value is wanted here"),
    "too_long": lambda error, _: UserError(f"more than {error['ctx']['max_length']} of them"),
}
