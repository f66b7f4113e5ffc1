"""What the governor's parameters make of the PDOs, and the init telegrams of it (7.1, 7.3)."""

from dataclasses import dataclass

from canopen_twins.devices.gateway.model.scaling import Scaling
from canopen_twins.devices.gateway.model.store import Store
from canopen_twins.devices.gateway.model.telegrams import (
    BinaryPart,
    InitPart,
    RpdoPart,
    Slot,
    TpdoPart,
)
from canopen_twins.devices.gateway.model.timing import MOST_CYCLES, cycles

SEND_ERRORS, SEND_STATUS = 14401, 14402
TPDO_ASSIGN, TPDO_CYCLE, RPDO_CYCLE = 16400, 16460, 16480
ANALOGUE_TPDOS = range(4, 17)
SWITCH_FUNCTIONS = range(811, 843)  # A-48; 810 stops the engine and is hard-wired (7.1.4.1)
SENSORS = range(900, 924)
TYPE = 4000  # a type has the number of its assignment plus this
CANOPEN = 3
WORDS = 4  # of a PDO
RPDOS = range(1, 5)


@dataclass(frozen=True)
class Tpdo:
    """One active analogue TPDO: which parameter each used word shows, and its main cycles."""

    number: int
    sources: dict[int, int]
    """Word 1..4 -> parameter number."""
    period: int


@dataclass(frozen=True)
class SwitchFunction:
    """A switch function that comes by CANopen."""

    number: int
    bit: int
    """Of word 1 of RPDO1, 1..16; negative: active while the bit is clear."""

    def active(self, word: int) -> bool:
        """Whether this word switches it on."""
        return bool(word >> (abs(self.bit) - 1) & 1) is (self.bit > 0)


@dataclass(frozen=True)
class Sensor:
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
    for number in ANALOGUE_TPDOS:
        place = number - ANALOGUE_TPDOS.start
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
        SwitchFunction(number, settings[number])
        for number in SWITCH_FUNCTIONS
        if settings[number + TYPE] == CANOPEN and settings[number]
    ]


def sensors(settings: Store) -> list[Sensor]:
    """The sensors that come by CANopen and are assigned to a channel."""
    return [
        Sensor(number, settings[number])
        for number in SENSORS
        if settings[number + TYPE] == CANOPEN and settings[number]
    ]


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
