"""Values of 2000h to 2004h in the gateway, and when a binary TPDO is due (4.1.1)."""

from enum import Enum

from simulators.devices.gateway.model.assignment import Assignment
from simulators.devices.gateway.model.canopen_bus import TpdoFrame
from simulators.devices.gateway.model.dictionary import DIGITAL, Dictionary, Entry

BINARY_TPDOS = (1, 2, 3)


class FirstTpdo(Enum):
    """Whether a binary TPDO is sent without a change after entering Operational (A-15)."""

    ALWAYS = "always"
    NONZERO = "nonzero"
    NEVER = "never"


class Outputs:
    """What the object dictionary holds, from its creation by the init telegrams on."""

    def __init__(self, dictionary: Dictionary, assignment: Assignment, first: FirstTpdo) -> None:
        self.dictionary = dictionary
        self._assignment, self._first = assignment, first
        self._values: dict[Entry, int] = {}
        self._sent: dict[int, tuple[int, ...]] = {}
        self._digital: tuple[int, ...] = (0,) * 7
        self._shown = (0, 0)
        self.news: list[TpdoFrame] = []
        """The binary TPDOs with something new in them, by the last `show`."""

    def begin(self) -> None:
        """Operational was entered: the binary TPDOs begin anew."""
        self._sent = {}

    def value(self, index: int, sub: int) -> int:
        """The value of a word of 2000h to 2004h; 0 before anything has come for it."""
        if index == DIGITAL:
            return self._digital[sub - 1]
        return self._values.get(Entry(index, sub), 0)

    def show(self, present: int, engine: int) -> None:
        """Take over errors, bit k for 3000+k, and engine state; once per cycle of the governor."""
        if self._sent and (present, engine) == self._shown:
            self.news = []
            return
        self._shown = present, engine
        self._digital = (*self._assignment.error_words(present), engine)
        words = {n: self._words(n) for n in BINARY_TPDOS if n in self.dictionary.tpdos}
        self.news = [TpdoFrame(n, each) for n, each in words.items() if self._is_new(n, each)]
        self._sent = words

    def take(self, entries: tuple[Entry, ...], words: tuple[int, ...]) -> None:
        """Keep the words of a PDO in their objects."""
        self._values |= dict(zip(entries, words, strict=True))

    def _words(self, number: int) -> tuple[int, ...]:
        entries = self.dictionary.tpdos[number].entries
        return tuple(self.value(entry.index, entry.sub) for entry in entries)

    def _is_new(self, number: int, words: tuple[int, ...]) -> bool:
        if number in self._sent:
            return words != self._sent[number]
        return {
            FirstTpdo.ALWAYS: True,
            FirstTpdo.NONZERO: any(words),
            FirstTpdo.NEVER: False,
        }[self._first]
