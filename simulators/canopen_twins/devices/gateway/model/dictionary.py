"""What the gateway makes of the init telegrams: identifiers, mappings, refusals (7.3)."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from canopen_twins.devices.gateway.model.configuration import ANALOGUE_TPDOS, WORDS
from canopen_twins.devices.gateway.model.store import Store
from canopen_twins.devices.gateway.model.telegrams import (
    BinaryPart,
    InitPart,
    Refusal,
    RpdoPart,
    TpdoPart,
)

OWN_NODE, PARTNER_NODE = 427, 428
TPDO_IDENTIFIER = 16404  # of TPDO5
PREDEFINED_TPDOS = range(1, 5)
DUMMY = 0x0006  # UNSIGNED16, for a word of an RPDO that nobody uses
DIGITAL, UNSIGNED, SIGNED, SWITCHES, SENSORS = range(0x2000, 0x2005)


@dataclass(frozen=True)
class Entry:
    """One mapped word."""

    index: int
    sub: int

    @property
    def mapping(self) -> int:
        """As it stands in 16xxh and 1Axxh."""
        return self.index << 16 | self.sub << 8 | 16


@dataclass(frozen=True)
class Pdo:
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
        if index == DIGITAL:
            mapped |= {*range(1, 7)}  # the errors are always there (5.1.1)
        return sorted(mapped)


def built(parts: Iterable[InitPart], settings: Store) -> Dictionary:
    """The dictionary for this configuration, with the identifiers of the gateway."""
    tpdos: dict[int, Pdo] = {}
    rpdos: dict[int, Pdo] = {}
    for part in parts:
        if isinstance(part, RpdoPart):
            rpdos[part.number] = Pdo(rpdo_identifier(part.number, settings), _received(part))
            continue
        sent = _binary(part) if isinstance(part, BinaryPart) else {part.number: _analogue(part)}
        for number, entries in sent.items():
            tpdos[number] = Pdo(tpdo_identifier(number, settings), entries)
    return Dictionary(tpdos, rpdos)


def tpdo_identifier(number: int, settings: Store) -> int:
    """By the node number for TPDO1 to 4 (Table 4), by 16404 onward for the others."""
    if number in PREDEFINED_TPDOS:
        return 0x80 + 0x100 * number + settings[OWN_NODE]
    return settings[TPDO_IDENTIFIER + number - PREDEFINED_TPDOS.stop]


def rpdo_identifier(number: int, settings: Store) -> int:
    """By the node number (Table 4)."""
    return 0x100 + 0x100 * number + settings[OWN_NODE]


def refusal(known: Dictionary, settings: Store) -> Refusal | None:
    """What is inconsistent about the active PDOs and the node numbers (7.3)."""
    own, partner = settings[OWN_NODE], settings[PARTNER_NODE]
    if own == partner:
        return Refusal.OWN_IS_PARTNER
    used = [pdo.identifier for pdo in (*known.tpdos.values(), *known.rpdos.values())]
    reserved = {0x000, 0x080, 0x100, 0x580 + own, 0x600 + own, 0x700 + own, 0x700 + partner}
    if reserved.intersection(used):
        return Refusal.RESERVED_IDENTIFIER
    if len(used) != len(dict.fromkeys(used)):
        return Refusal.DUPLICATE_IDENTIFIER
    return None


def _binary(part: BinaryPart) -> dict[int, tuple[Entry, ...]]:
    wanted = {1: range(1, 5), 2: range(5, 7)} if part.errors else {}
    if part.status:
        wanted[3] = range(7, 8)
    return {tpdo: tuple(Entry(DIGITAL, sub) for sub in subs) for tpdo, subs in wanted.items()}


def _analogue(part: TpdoPart) -> tuple[Entry, ...]:
    before = WORDS * (part.number - ANALOGUE_TPDOS.start)
    return tuple(
        Entry(SIGNED if slot.signed else UNSIGNED, before + slot.word) for slot in part.slots
    )


def _received(part: RpdoPart) -> tuple[Entry, ...]:
    if part.number == 1:
        objects = {1: Entry(SWITCHES, 1), 3: Entry(SWITCHES, 2)}
    else:
        before = WORDS * (part.number - 2)
        objects = {word: Entry(SENSORS, before + word) for word in part.words}
    return tuple(
        objects[word] if word in part.words else Entry(DUMMY, 0)
        for word in range(1, max(part.words) + 1)
    )
