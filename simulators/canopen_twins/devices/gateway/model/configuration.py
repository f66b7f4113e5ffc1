"""PDOs: what the governor's parameters want, and what the gateway makes of that (7.1, 7.3)."""

from collections.abc import Iterable, Mapping, Sequence
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
OWN_NODE, PARTNER_NODE, HEARTBEAT_PERIOD, HEARTBEAT_LIMIT = range(427, 431)
TPDO_IDENTIFIER = 16404  # of TPDO5

WORDS = 4  # of a PDO
RPDOS, PREDEFINED_TPDOS, ANALOGUE_TPDOS = range(1, 5), range(1, 5), range(4, 17)
STATUS_WORDS = {1: range(1, 5), 2: range(5, 7), 3: range(7, 8)}  # 2000h in TPDO1 to 3 (4.1.1)
DUMMY = 0x0006  # UNSIGNED16, for a word of an RPDO that nobody uses
DIGITAL_OUTPUT, UNSIGNED_OUTPUT, SIGNED_OUTPUT, DIGITAL_INPUT, ANALOG_INPUT = range(0x2000, 0x2005)


class Slot(NamedTuple):
    """One word of an analogue TPDO: its place among the four assignments, and its sign."""

    word: int  # 1..4
    signed: bool


@dataclass(frozen=True)
class BinaryPart:
    """Init telegram: which binary TPDOs are wanted (14401, 14402)."""

    errors: bool
    status: bool


@dataclass(frozen=True)
class TpdoPart:
    """Init telegram: one active analogue TPDO, 4..16."""

    number: int
    slots: tuple[Slot, ...]


@dataclass(frozen=True)
class RpdoPart:
    """Init telegram: one active RPDO, 1..4, and which of its words 1..4 are used."""

    number: int
    words: tuple[int, ...]


InitPart = BinaryPart | TpdoPart | RpdoPart


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
    active = [part.number for part in _rpdo_parts(settings)]
    return [
        cycles(settings[RPDO_CYCLE + rpdo - 1], cycle, MOST_CYCLES) if rpdo in active else 0
        for rpdo in RPDOS
    ]


def init_parts(settings: Store, scaling: Scaling, cycle: int) -> list[InitPart]:
    """The configuration as the init telegrams carry it: only active PDOs are in it (7.3)."""
    binary = BinaryPart(bool(settings[SEND_ERRORS]), bool(settings[SEND_STATUS]))
    analogue = [_tpdo_part(tpdo, scaling) for tpdo in tpdos(settings, scaling, cycle)]
    return [binary, *analogue, *_rpdo_parts(settings)]


def _tpdo_part(tpdo: Tpdo, scaling: Scaling) -> TpdoPart:
    parameters = {word: scaling.analogue(number) for word, number in tpdo.sources.items()}
    slots = (Slot(word, each.signed) for word, each in parameters.items() if each)
    return TpdoPart(tpdo.number, tuple(slots))


def _rpdo_parts(settings: Store) -> list[RpdoPart]:
    known = sensors(settings)
    binary = [1] * bool(switch_functions(settings)) + [3] * bool(known)  # 4.2.1
    words = {1: binary} | {
        rpdo: sorted({sensor.word for sensor in known if sensor.rpdo == rpdo}) for rpdo in (2, 3, 4)
    }
    return [RpdoPart(rpdo, tuple(used)) for rpdo, used in words.items() if used]


@dataclass(frozen=True)
class Entry:
    """One mapped word."""

    index: int
    sub: int

    @property
    def mapping(self) -> int:
        """As it stands in 16xxh and 1Axxh."""
        return self.index << 16 | self.sub << 8 | 16


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
    for part in parts:
        if isinstance(part, RpdoPart):  # by the node number (Table 4)
            rpdos[part.number] = Pdo(0x100 + 0x100 * part.number + settings[OWN_NODE], _words(part))
            continue
        sent = _binary(part) if isinstance(part, BinaryPart) else {part.number: _analogue(part)}
        for number, entries in sent.items():
            tpdos[number] = Pdo(_tpdo_identifier(number, settings), entries)
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


def _binary(part: BinaryPart) -> dict[int, tuple[Entry, ...]]:
    wanted = [1, 2] * part.errors + [3] * part.status
    return {n: tuple(Entry(DIGITAL_OUTPUT, sub) for sub in STATUS_WORDS[n]) for n in wanted}


def _analogue(part: TpdoPart) -> tuple[Entry, ...]:
    before = WORDS * (part.number - ANALOGUE_TPDOS.start)
    return tuple(
        Entry(SIGNED_OUTPUT if slot.signed else UNSIGNED_OUTPUT, before + slot.word)
        for slot in part.slots
    )


def _words(part: RpdoPart) -> tuple[Entry, ...]:
    if part.number == 1:
        objects = {1: Entry(DIGITAL_INPUT, 1), 3: Entry(DIGITAL_INPUT, 2)}
    else:
        before = WORDS * (part.number - 2)
        objects = {word: Entry(ANALOG_INPUT, before + word) for word in part.words}
    return tuple(
        objects[word] if word in part.words else Entry(DUMMY, 0)
        for word in range(1, max(part.words) + 1)
    )
