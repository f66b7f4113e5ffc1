"""Loads as text, such as "battery 350 V 0.1 ohm diode"."""

from dataclasses import MISSING, Field, fields
from typing import Any

from simulators.devices.topcon.model.hints import did_you_mean
from simulators.devices.topcon.model.loads import (
    Battery,
    CurrentSink,
    Inductor,
    Load,
    Open,
    PowerSink,
    Resistor,
    Short,
)

LOADS: dict[str, type[Load]] = {
    load.word: load for load in (Open, Resistor, Battery, CurrentSink, PowerSink, Short, Inductor)
}


def parse_load(text: str) -> Load:
    """The load a text describes: a word, its values in SI units, a unit word after each if liked.

    Raises ValueError with one line that says what would be right.
    """
    word, *rest = text.split() or [""]
    if word not in LOADS:
        hint = did_you_mean(word, LOADS)
        raise ValueError(f"no load is called {word!r}{hint}: {', '.join(LOADS)}")
    kind = LOADS[word]
    try:
        values = {part.name: _take(part, rest) for part in fields(kind)}
        if rest:
            raise ValueError(f"{' '.join(rest)!r} is too much")
    except ValueError as refusal:
        raise ValueError(f"load {text!r}: {refusal}, write {_usage(kind)!r}") from None
    return kind(**values)


def _take(part: "Field[Any]", rest: list[str]) -> Any:
    """Remove a value from the front of the words; where none is, the default."""
    if part.type is bool:
        given = rest[:1] == [part.name]
        del rest[: int(given)]
        return given
    if not rest and part.default is not MISSING:
        return part.default
    try:
        value = float(rest.pop(0))
    except (IndexError, ValueError):
        raise ValueError(f"{part.name} is not a number") from None
    if rest and rest[0] == part.metadata["unit"]:
        del rest[0]
    return value


def _usage(kind: type[Load]) -> str:
    return " ".join([kind.word, *(_slot(part) for part in fields(kind))])


def _slot(part: "Field[Any]") -> str:
    if part.type is bool:
        return f"[{part.name}]"
    slot = f"<{part.metadata['unit']}>"
    return slot if part.default is MISSING else f"[{slot}]"
