"""Which error and which engine state each bit of 2000h stands for (A-13, A-33)."""

from collections.abc import Mapping, Sequence
from typing import Any

from canopen_twins.devices.gateway.model.errors import FIRST, numbers

WORDS = range(1, 7)  # 2000h:01-06
ERROR_BITS = 16
ENGINE_BITS = 8  # 5.1.1
ERROR_NUMBERS = range(FIRST, FIRST + 100)
ENGINE_STATES = (
    "stopped",
    "cranking",
    "running",
    "idle",
    "setpoint reached",
    "running down",
    "load connected",
    "overspeed stop",
)


class Assignment:
    """The bits of 2000h as lists, bit 0 first; None is a bit that is always 0."""

    def __init__(self, rows: Sequence[Sequence[int | None]], engine: Sequence[str | None]) -> None:
        self._places = {
            number: (word, bit)
            for word, row in enumerate(rows)
            for bit, number in enumerate(row)
            if number is not None
        }
        self._engine = {state: 1 << bit for bit, state in enumerate(engine) if state is not None}

    def error_words(self, present: int) -> tuple[int, ...]:
        """2000h:01 to :06 for these errors; bit k of `present` is error 3000+k."""
        words = [0] * len(WORDS)
        for number in numbers(present):
            if number in self._places:
                word, bit = self._places[number]
                words[word] |= 1 << bit
        return tuple(words)

    def engine_word(self, states: Mapping[str, bool]) -> int:
        """2000h:07 for these engine states."""
        word = 0
        for state, bit in self._engine.items():
            if states[state]:
                word |= bit
        return word


def assignment(content: Any) -> Assignment:
    """The assignment of a parsed file: `error bits` with six lists, `engine state bits` with one.

    Raises:
        ValueError: a key, list or entry that is not as described.
    """
    if not isinstance(content, Mapping) or set(content) != {"error bits", "engine state bits"}:
        raise ValueError("the keys are not just 'error bits' and 'engine state bits'")
    words = content["error bits"]
    if not isinstance(words, Mapping) or list(words) != list(WORDS):
        raise ValueError("error bits: there is not one list for each of 1..6, in this order")
    errors = [_bits(f"error bits {word}", words[word], ERROR_BITS, ERROR_NUMBERS) for word in WORDS]
    _check_unique("error bits", [entry for word in errors for entry in word])
    engine = _bits("engine state bits", content["engine state bits"], ENGINE_BITS, ENGINE_STATES)
    _check_unique("engine state bits", engine)
    return Assignment(errors, engine)


def _bits(where: str, entries: Any, most: int, known: Sequence[Any]) -> list[Any]:
    if not isinstance(entries, list) or len(entries) > most:
        raise ValueError(f"{where}: is no list of at most {most} bits")
    for entry in entries:
        if entry is not None and entry not in known:
            raise ValueError(f"{where}: {entry!r} is none of {known[0]} to {known[-1]}")
    return entries


def _check_unique(where: str, entries: Sequence[Any]) -> None:
    given = [entry for entry in entries if entry is not None]
    for entry in given:
        if given.count(entry) > 1:
            raise ValueError(f"{where}: {entry!r} is there twice")
