"""PDOs: what the governor's parameters want, and what the gateway makes of that (7.1, 7.3)."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from canopen_twins.devices.gateway.model.parameters import Scaling, Store
from canopen_twins.devices.gateway.model.timing import MOST_CYCLES, cycles

# of the governor
SEND_ERRORS, SEND_STATUS = 14401, 14402
TPDO_ASSIGN, TPDO_CYCLE, RPDO_CYCLE = 16400, 16460, 16480
SWITCH_FUNCTIONS = range(811, 843)  # A-48; 810 stops the engine and is hard-wired (7.1.4.1)
SENSORS = range(900, 924)
TYPE = 4000  # a type has the number of its assignment plus this
CANOPEN = 3

# of the gateway
CANOPEN_BAUDRATE = 426
OWN_NODE, PARTNER_NODE, HEARTBEAT_PERIOD, HEARTBEAT_LIMIT = range(427, 431)
TPDO_IDENTIFIER = 16404  # of TPDO5

WORDS = 4  # of a PDO
RPDOS, PREDEFINED_TPDOS, ANALOGUE_TPDOS = range(1, 5), range(1, 5), range(4, 17)
DUMMY = 0x0006  # UNSIGNED16, for a word of an RPDO that nobody uses
DIGITAL_OUTPUT, UNSIGNED_OUTPUT, SIGNED_OUTPUT, DIGITAL_INPUT, ANALOG_INPUT = range(0x2000, 0x2005)


@dataclass(frozen=True)
class Entry:
    """One mapped word."""

    index: int
    sub: int

    @property
    def mapping(self) -> int:
        """As it stands in 16xxh and 1Axxh."""
        return self.index << 16 | self.sub << 8 | 16


BINARY_TPDOS = {  # 4.1.1
    number: tuple(Entry(DIGITAL_OUTPUT, sub) for sub in subs)
    for number, subs in {1: range(1, 5), 2: range(5, 7), 3: range(7, 8)}.items()
}


class ActivePdo(NamedTuple):
    """What an init telegram tells of a PDO: that it is active, and the words in it."""

    sent: bool
    """Whether it is a TPDO, 1..16; else an RPDO, 1..4."""
    number: int
    entries: tuple[Entry, ...]


InitPart = tuple[ActivePdo, ...]
"""One init telegram: the binary TPDOs together, of the others one each."""


class Tpdo(NamedTuple):
    """One active analogue TPDO: which parameter each used word 1..4 shows, and its main cycles."""

    number: int
    sources: dict[int, int]
    period: int


class SwitchFunction(NamedTuple):
    """A switch function that comes by CANopen."""

    number: int
    bit: int
    """Of word 1 of RPDO1, 1..16; negative: active while the bit is clear."""

    def active(self, word: int) -> bool:
        """Whether this word switches it on."""
        return bool(word >> (abs(self.bit) - 1) & 1) is (self.bit > 0)


class Sensor(NamedTuple):
    """A sensor that comes by CANopen."""

    number: int
    channel: int
    """1..12: word 1 of RPDO2 to word 4 of RPDO4."""

    @property
    def rpdo(self) -> int:
        """The RPDO that carries it."""
        return 2 + (self.channel - 1) // WORDS

    @property
    def word(self) -> int:
        """Its place there, 1..4."""
        return (self.channel - 1) % WORDS + 1


def tpdos(settings: Store, scaling: Scaling, cycle: int) -> list[Tpdo]:
    """The active analogue TPDOs; an assignment that cannot be sent is left out (7.1.2.2)."""
    active = []
    for place, number in enumerate(ANALOGUE_TPDOS):
        first = TPDO_ASSIGN + WORDS * place
        assigned = {word: settings[first + word - 1] for word in range(1, WORDS + 1)}
        sources = {word: each for word, each in assigned.items() if scaling.analogue(each)}
        period = cycles(settings[TPDO_CYCLE + place], cycle, MOST_CYCLES)
        if sources and period:
            active.append(Tpdo(number, sources, period))
    return active


def switch_functions(settings: Store) -> list[SwitchFunction]:
    """The switch functions that come by CANopen and are assigned to a bit."""
    return [
        SwitchFunction(number, settings[number]) for number in _used(settings, SWITCH_FUNCTIONS)
    ]


def sensors(settings: Store) -> list[Sensor]:
    """The sensors that come by CANopen and are assigned to a channel."""
    return [Sensor(n, settings[n]) for n in _used(settings, SENSORS)]


def _used(settings: Store, numbers: Sequence[int]) -> list[int]:
    return [n for n in numbers if settings[n + TYPE] == CANOPEN and settings[n]]


def monitoring(settings: Store, cycle: int) -> list[int]:
    """Main cycles after which each of the four RPDOs is missed; 0: it is not (7.1.5, A-37)."""
    active = _rpdo_words(settings)
    return [
        cycles(settings[RPDO_CYCLE + rpdo - 1], cycle, MOST_CYCLES) if rpdo in active else 0
        for rpdo in RPDOS
    ]


def init_parts(settings: Store, scaling: Scaling, cycle: int) -> list[InitPart]:
    """The configuration as the init telegrams carry it: only active PDOs are in it (7.3)."""
    wanted = [1, 2] * bool(settings[SEND_ERRORS]) + [3] * bool(settings[SEND_STATUS])
    binary = tuple(ActivePdo(True, number, BINARY_TPDOS[number]) for number in wanted)
    analogue = (
        ActivePdo(True, tpdo.number, tuple(_output(tpdo, word, scaling) for word in tpdo.sources))
        for tpdo in tpdos(settings, scaling, cycle)
    )
    received = (
        ActivePdo(False, rpdo, tuple(_input(rpdo, word, used) for word in range(1, max(used) + 1)))
        for rpdo, used in _rpdo_words(settings).items()
    )
    return [binary, *((pdo,) for pdo in (*analogue, *received))]


def _output(tpdo: Tpdo, word: int, scaling: Scaling) -> Entry:
    index = SIGNED_OUTPUT if scaling.of(tpdo.sources[word]).signed else UNSIGNED_OUTPUT
    return Entry(index, WORDS * (tpdo.number - ANALOGUE_TPDOS.start) + word)


def _input(rpdo: int, word: int, used: Collection[int]) -> Entry:
    if word not in used:
        return Entry(DUMMY, 0)
    if rpdo == 1:
        return Entry(DIGITAL_INPUT, {1: 1, 3: 2}[word])
    return Entry(ANALOG_INPUT, WORDS * (rpdo - 2) + word)


def _rpdo_words(settings: Store) -> dict[int, list[int]]:
    """Which words are used of each active RPDO."""
    known = sensors(settings)
    words = {1: [1] * bool(switch_functions(settings)) + [3] * bool(known)}  # 4.2.1
    for rpdo in (2, 3, 4):
        words[rpdo] = sorted({sensor.word for sensor in known if sensor.rpdo == rpdo})
    return {rpdo: used for rpdo, used in words.items() if used}


class Pdo(NamedTuple):
    """One active PDO."""

    identifier: int
    entries: tuple[Entry, ...]


@dataclass(frozen=True)
class Dictionary:
    """The part of the object dictionary that depends on the configuration."""

    tpdos: Mapping[int, Pdo]
    rpdos: Mapping[int, Pdo]

    def subs(self, index: int) -> Sequence[int]:
        """The sub-indices above 0 of 2000h to 2004h (5.1)."""
        pdos = (*self.tpdos.values(), *self.rpdos.values())
        mapped = {entry.sub for pdo in pdos for entry in pdo.entries if entry.index == index}
        if index == DIGITAL_OUTPUT:
            mapped |= {*range(1, 7)}  # the errors are always there (5.1.1)
        return sorted(mapped)


class Refusal(Enum):
    """Why the gateway does not accept its configuration (7.3)."""

    STRUCTURE = "init telegrams are missing"
    DUPLICATE_IDENTIFIER = "two active PDOs have the same identifier"
    RESERVED_IDENTIFIER = "an active PDO has a reserved identifier"
    OWN_IS_PARTNER = "427 and 428 are the same node"


def built(parts: Iterable[InitPart], settings: Store) -> Dictionary:
    """The dictionary for this configuration, with the identifiers of the gateway."""
    tpdos: dict[int, Pdo] = {}
    rpdos: dict[int, Pdo] = {}
    for sent, number, entries in (pdo for part in parts for pdo in part):
        if sent:
            tpdos[number] = Pdo(_tpdo_identifier(number, settings), entries)
        else:  # by the node number (Table 4)
            rpdos[number] = Pdo(0x100 + 0x100 * number + settings[OWN_NODE], entries)
    return Dictionary(tpdos, rpdos)


def refusal(known: Dictionary, settings: Store) -> Refusal | None:
    """What is inconsistent about the active PDOs and the node numbers (7.3)."""
    own, partner = settings[OWN_NODE], settings[PARTNER_NODE]
    if own == partner:
        return Refusal.OWN_IS_PARTNER
    used = [pdo.identifier for pdo in (*known.tpdos.values(), *known.rpdos.values())]
    reserved = {0x000, 0x080, 0x100, 0x580 + own, 0x600 + own, 0x700 + own, 0x700 + partner}
    if reserved.intersection(used):
        return Refusal.RESERVED_IDENTIFIER
    return Refusal.DUPLICATE_IDENTIFIER if len(used) != len(set(used)) else None


def _tpdo_identifier(number: int, settings: Store) -> int:
    """By the node number for TPDO1 to 4 (Table 4), by 16404 onward for the others."""
    if number in PREDEFINED_TPDOS:
        return 0x80 + 0x100 * number + settings[OWN_NODE]
    return settings[TPDO_IDENTIFIER + number - PREDEFINED_TPDOS.stop]
