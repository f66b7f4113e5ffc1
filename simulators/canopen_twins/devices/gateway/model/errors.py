"""Errors 3000 to 3099 of a control unit, their counters, and what 2000h and 2005h tell of them."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import IntFlag
from typing import Any

FIRST = 3000
COUNTERS = 100  # a counter has the number of its error plus this (9.2)
MOST = 255  # 11.3, range of the counters

CAN_BUS_1, CAN_COMM_1, CAN_BUS_2, CAN_COMM_2, CAN_OPEN = range(3070, 3075)
PICK_UP = 3001
OVERSPEED = 3004
FIRST_SENSOR = 3005  # 9.6; sensor 900+s has 3005+s
PARAM_STORE = 3076
RAM_TEST = 3078
VOLTAGE = 3085
MAIN_CHECKSUM = 3087
WATCHDOG = 3089
INTERN = 3094

# of the engine
OIL_WARNING, OIL_STOP, AIR_WARNING, AIR_STOP = range(3030, 3034)
START_FAILED, UNDERSPEED, STALLED = range(3034, 3037)
OF_ENGINE = range(OIL_WARNING, STALLED + 1)
STOPPING = (OVERSPEED, OIL_STOP, AIR_STOP, START_FAILED, STALLED)
"""The engine is stopped, and does not start before they are cleared."""

FATAL = (PARAM_STORE, 3077, RAM_TEST, 3090, 3093, INTERN)  # 9.4: Undefined until reset
SENSORS = range(FIRST_SENSOR, FIRST_SENSOR + 24)


def bit(number: int) -> int:
    """The bit that stands for error 3000+k: k."""
    return 1 << (number - FIRST)


def bits(numbers: Iterable[int]) -> int:
    """A word with the bits of these errors."""
    return sum(bit(number) for number in numbers)


def numbers(word: int) -> Iterator[int]:
    """The errors whose bits are set, in ascending order."""
    while word:
        lowest = word & -word
        yield FIRST + lowest.bit_length() - 1
        word ^= lowest


# These go with their cause (9.4 for 3085; A-11); the others stay until cleared.
FOLLOWING = bits(
    (
        *(PICK_UP, *SENSORS, OIL_WARNING, AIR_WARNING),
        *(CAN_BUS_1, CAN_COMM_1, CAN_BUS_2, CAN_COMM_2, CAN_OPEN, VOLTAGE),
    )
)


class ErrorMemory:
    """Both error memories of one control unit (9.1, 9.2)."""

    def __init__(self) -> None:
        self.present = 0
        """Bit k: error 3000+k is reported. Lost without power."""
        self.counts: dict[int, int] = {}
        """How often an error has occurred, by its number; kept for ever."""

    def update(self, causes: int) -> None:
        """Take over what is wrong now, one bit per error; what was not present is counted."""
        if causes == self.present:  # most of the time
            return
        for number in numbers(causes & ~self.present):
            self.counts[number] = min(self.counts.get(number, 0) + 1, MOST)
        self.present = self.present & ~FOLLOWING | causes

    def has(self, number: int) -> bool:
        """Whether this error is reported."""
        return bool(self.present & bit(number))

    def clear(self) -> None:
        """Clear all errors; those whose cause is still there are reported again (9.1)."""
        self.present = 0

    def clear_counts(self) -> None:
        """Clear the permanent memory, as only a PC or hand programmer can (9.2)."""
        self.counts = {}


class CanopenError(IntFlag):
    """Errors of CANopen communication, 9.5: bits of 2005h (Table 2)."""

    DC_RESET = 1 << 0
    INIT = 1 << 1
    TIME_CTRL = 1 << 2
    DC_CAN_BUS = 1 << 3
    DC_CAN_COMM = 1 << 4
    GW_RESET = 1 << 8
    HEARTBEAT = 1 << 9
    GW_CAN_BUS_1 = 1 << 10
    GW_CAN_COMM_1 = 1 << 11
    GW_CAN_BUS_2 = 1 << 12
    GW_CAN_COMM_2 = 1 << 13


CANOPEN_ERRORS = {12411 + each.bit_length() - 1: each for each in CanopenError}
"""By their parameters, 12411 to 12424."""
OF_GOVERNOR: Mapping[int, CanopenError] = {
    CAN_BUS_1: CanopenError.DC_CAN_BUS,
    CAN_COMM_1: CanopenError.DC_CAN_COMM,
}
OF_GATEWAY: Mapping[int, CanopenError] = {
    CAN_BUS_1: CanopenError.GW_CAN_BUS_1,
    CAN_COMM_1: CanopenError.GW_CAN_COMM_1,
    CAN_BUS_2: CanopenError.GW_CAN_BUS_2,
    CAN_COMM_2: CanopenError.GW_CAN_COMM_2,
}
REGISTERED = bits(range(CAN_BUS_1, INTERN + 1))


def error_register(present: int, word: CanopenError) -> int:
    """Object 1001h: generic, voltage and communication error of the gateway (A-07)."""
    generic, voltage = bool(present & REGISTERED), bool(present & bit(VOLTAGE))
    return generic << 0 | voltage << 2 | bool(word) << 4


class CanopenErrors:
    """What one unit knows: its own bits, and those its partner told it last (A-12)."""

    def __init__(self, reasons: Mapping[int, CanopenError]) -> None:
        self._reasons = reasons
        self._relevant = bits(reasons)
        self.own = CanopenError(0)
        self.partner = CanopenError(0)

    @property
    def word(self) -> CanopenError:
        """Object 2005h, as this unit sees it."""
        if not self.partner:  # most of the time
            return self.own
        return self.own | self.partner

    def latch(self, causes: int) -> None:
        """Set what the errors 3070 to 3073 among the causes stand for; it stays when they go."""
        if causes & self._relevant:
            self.own |= self._standing_for(causes)

    def follow(self, error: CanopenError, present: bool) -> None:
        """Let an error come and go with its cause (12413, 12420)."""
        if bool(self.own.value & error.value) is not present:  # most of the time it is as it was
            self.own ^= error

    def clear(self, causes: int) -> None:
        """Clear all but what has a cause here: by clearing all errors, or in Operational (9.5).

        The partner does the same, and tells what it has left.
        """
        self.own, self.partner = self._standing_for(causes), CanopenError(0)

    def _standing_for(self, causes: int) -> CanopenError:
        present = CanopenError(0)
        for number, error in self._reasons.items():
            if causes & bit(number):
                present |= error
        return present


WORDS = range(1, 7)  # 2000h:01-06
ERROR_BITS, ENGINE_BITS = 16, 8  # 5.1.1
ENGINE_STATES = (
    *("stopped", "cranking", "running", "idle", "setpoint reached", "running down"),
    *("load connected", "overspeed stop"),
)


class Assignment:
    """Which error or engine state each bit of 2000h stands for (A-13, A-33).

    The bits are lists, bit 0 first; None is a bit that is always 0.
    """

    def __init__(self, rows: Sequence[Sequence[int | None]], engine: Sequence[str | None]) -> None:
        self._places = {
            number: (word, place)
            for word, row in enumerate(rows)
            for place, number in enumerate(row)
            if number is not None
        }
        self._engine = {state: 1 << place for place, state in enumerate(engine) if state}

    def error_words(self, present: int) -> tuple[int, ...]:
        """2000h:01 to :06 for these errors; bit k of `present` is error 3000+k."""
        words = [0] * len(WORDS)
        for number in numbers(present):
            if number in self._places:
                word, place = self._places[number]
                words[word] |= 1 << place
        return tuple(words)

    def engine_word(self, states: Mapping[str, bool]) -> int:
        """2000h:07 for these engine states."""
        word = 0
        for state, its_bit in self._engine.items():
            if states[state]:
                word |= its_bit
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
    known = range(FIRST, FIRST + 100)
    rows = [_entries(f"error bits {word}", words[word], ERROR_BITS, known) for word in WORDS]
    _check_unique("error bits", [entry for row in rows for entry in row])
    engine = _entries("engine state bits", content["engine state bits"], ENGINE_BITS, ENGINE_STATES)
    _check_unique("engine state bits", engine)
    return Assignment(rows, engine)


def _entries(where: str, entries: Any, most: int, known: Sequence[Any]) -> list[Any]:
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
