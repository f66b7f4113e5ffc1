"""Values as users write them, converted to the kind that is wanted."""

import re
from collections.abc import Mapping
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


PLAIN = dict.fromkeys(
    ("V", "A", "W", "%", "ohm", "ohms", "F", "H", "Ah", "Hz", "s", "degC", "°C", "K", "rpm", "bar"),
    1.0,
)
"""Units that may stand behind a number by mistake; one with a prefix is not guessed at."""
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0, "h": 3600.0}
QUANTITY = re.compile(r"([-+]?[0-9]+(?:\.[0-9]+)?) ?(\S+)")
WITH_A_COMMA = re.compile(r"([-+]?[0-9]+),([0-9]+)")


def meant_number(text: str, units: Mapping[str, float] = PLAIN) -> str:
    """What to write for a number with its unit or with a comma; empty if it is no such one."""
    if comma := WITH_A_COMMA.fullmatch(text):
        return f"write {comma[1]}.{comma[2]}, with a point"
    found = QUANTITY.fullmatch(text)
    if found is None or found[2] not in units:
        return ""
    return f"write {float(found[1]) * units[found[2]]:.12g}"


def convert(what: str, value: object, kind: type) -> object:
    """A value as a whole number, a number, a truth value or a text.

    Raises:
        UserError: it is none; `what` says whose value it is.
    """
    try:
        return _scalar(value, kind)
    except (ValueError, TypeError, KeyError, OverflowError):
        hint = meant_number(value) if kind in {int, float} and isinstance(value, str) else ""
        told = f"{what} wants {KINDS[kind]}, not {value!r}"
        raise UserError(f"{told}: {hint}" if hint else told) from None


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
