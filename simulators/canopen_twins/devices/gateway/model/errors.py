"""Errors 3000 to 3099 of one control unit, and how often each has occurred: 3100 to 3199."""

from collections.abc import Iterable, Iterator

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
    (PICK_UP, *SENSORS, CAN_BUS_1, CAN_COMM_1, CAN_BUS_2, CAN_COMM_2, CAN_OPEN, VOLTAGE)
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
