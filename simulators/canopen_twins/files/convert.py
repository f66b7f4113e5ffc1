"""Values as users write them, converted to the kind that is wanted."""

from math import isfinite

from canopen_twins.errors import UserError

WORDS = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
KINDS = {
    int: "a whole number",
    float: "a number",
    bool: "true or false",
    str: "a text",
    object: "a number or a text",
}


def convert(what: str, value: object, kind: type) -> object:
    """A value as a whole number, a number, a truth value or a text.

    Raises:
        UserError: it is none; `what` says whose value it is.
    """
    try:
        return _scalar(value, kind)
    except (ValueError, TypeError, KeyError, OverflowError):
        raise UserError(f"{what} wants {KINDS[kind]}, not {value!r}") from None


def _scalar(value: object, kind: type) -> object:
    if kind is bool:
        return value if isinstance(value, bool) else WORDS[str(value).lower()]
    if kind is object and isinstance(value, (int, str)) and not isinstance(value, bool):
        return value
    if isinstance(value, bool) or not isinstance(value, str if kind is str else (str, int, float)):
        raise TypeError(value)  # a number is no text: is it 4.20 or 4.2?
    if kind is int and isinstance(value, float) and not value.is_integer():
        raise ValueError(value)
    if kind is int and isinstance(value, str):
        return int(value, 0)
    if kind is float and not isfinite(float(value)):
        raise ValueError(value)
    return kind(value)
