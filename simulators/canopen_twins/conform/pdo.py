"""PDOs as a slave has them, and topics about what their records say."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from canopen_twins.bus import identifiers
from canopen_twins.bus.sdo import Address
from canopen_twins.conform.tester import SILENCE, Failed, NotApplicable, Tester
from canopen_twins.conform.topic import Group
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.object import DUMMY_TYPES, entries_of

PDOS = Group(3, "PDO", "pdo")

RPDOS, TPDOS = range(0x1400, 0x1600), range(0x1800, 0x1A00)
MAPPINGS = 0x200  # from a communication record to its mapping
COB_ID, TYPE, INHIBIT_TIME, EVENT_TIMER = 1, 2, 3, 5
SYNC_COB_ID = 0x1005
LONGEST = 64  # bits
PREDEFINED = {RPDOS: 0x200, TPDOS: 0x180}
EVENTS = (254, 255)
SETTINGS = {INHIBIT_TIME: "inhibit time", EVENT_TIMER: "event timer"}
NOTHING: Mapping[int, int] = {}


class Pdo(NamedTuple):
    """A PDO in force."""

    record: int
    """The index of it."""
    can_id: int
    parts: tuple[tuple[Address, int], ...]
    """What is mapped, each with its bits."""

    @property
    def mapping(self) -> int:
        """The index of its mapping."""
        return self.record + MAPPINGS

    @property
    def size(self) -> int:
        """Bytes of a frame."""
        return -(-sum(bits for _, bits in self.parts) // 8)


def records(tester: Tester, area: range) -> list[int]:
    """The communication records that the dictionary has, with a mapping."""
    has = [index for index in area if tester.entry(index, COB_ID) is not None]
    return [index for index in has if tester.entry(index + MAPPINGS) is not None]


def parts(tester: Tester, mapping: int) -> tuple[tuple[Address, int], ...]:
    """What is mapped now."""
    count = min(tester.number(mapping), LONGEST)  # 254 and 255 are multiplexed PDOs
    values = [tester.number(mapping, sub) for sub in range(1, count + 1)]
    return tuple(
        ((value >> 16 & 0xFFFF, value >> 8 & 0xFF), value & 0xFF) for value in values if value
    )


def valid(tester: Tester, area: range) -> Iterator[Pdo]:
    """Those that are in force now."""
    for index in records(tester, area):
        can_id = identifiers.of_cob_id(tester.number(index, COB_ID))
        if can_id is not None:
            yield Pdo(index, can_id, parts(tester, index + MAPPINGS))


def sent_ids(tester: Tester) -> Collection[int]:
    """The identifiers of the TPDOs in force."""
    return {pdo.can_id for pdo in valid(tester, TPDOS)}


def need_records(tester: Tester, area: range) -> list[int]:
    """Those of an area.

    Raises:
        NotApplicable: there are none.
    """
    if not (found := records(tester, area)):
        raise NotApplicable("there is no such PDO", area.start)
    return found


Settings = Mapping[int, int]
"""Values by sub-indices of a communication record."""


def obtain(tester: Tester, area: range, types: Sequence[int], settings: Settings = NOTHING) -> Pdo:
    """A PDO with one of some transmission types and with settings, in force, which maps something.

    Raises:
        NotApplicable: no PDO can be set to that.
    """
    for index in need_records(tester, area):
        mapped = parts(tester, index + MAPPINGS)
        bits = sum(bits for _, bits in mapped)
        if 0 < bits <= LONGEST and _obtain(tester, index, types, settings):
            return Pdo(index, tester.number(index, COB_ID) & identifiers.CAN_ID, mapped)
    told = "".join(f" and {SETTINGS[sub]} {value}" for sub, value in settings.items())
    raise NotApplicable(f"no PDO can be set to type {_told(types)}{told}", area.start)


def _told(types: Sequence[int]) -> str:
    return f"{types[0]} to {types[-1]}" if len(types) > 2 else " or ".join(map(str, types))


def _obtain(tester: Tester, index: int, types: Sequence[int], settings: Settings) -> bool:
    """Whether a PDO is in force with that now."""
    cob_id = tester.number(index, COB_ID)
    pending = {sub: [value] for sub, value in settings.items() if _now(tester, index, sub) != value}
    if _now(tester, index, TYPE) not in types:
        pending[TYPE] = [*types]
    if pending:
        off = _write(tester, index, COB_ID, [cob_id | identifiers.INVALID])
        done = off and all(_write(tester, index, sub, values) for sub, values in pending.items())
        if not done:
            _write(tester, index, COB_ID, [cob_id])
            return False
    on = cob_id & ~identifiers.INVALID
    is_on = on == cob_id and not pending
    return is_on or _write(tester, index, COB_ID, [on])


def _now(tester: Tester, index: int, subindex: int) -> int | None:
    return tester.number(index, subindex) if tester.entry(index, subindex) is not None else None


def _write(tester: Tester, index: int, subindex: int, values: Iterable[int]) -> bool:
    """Whether an entry has taken one of some values."""
    entry = tester.entry(index, subindex)
    if entry is None or not entry.writable:
        return False
    return any(tester.try_write((index, subindex), value) == 0 for value in values)


def switch_off(tester: Tester, pdo: Pdo) -> int:
    """Set bit 31 of a COB-ID; what it was before.

    Raises:
        NotApplicable: it cannot be written.
    """
    tester.need_writable(pdo.record, COB_ID)
    cob_id = tester.number(pdo.record, COB_ID)
    tester.write((pdo.record, COB_ID), cob_id | identifiers.INVALID)
    return cob_id


def produce_sync(tester: Tester) -> None:
    """Let SYNC come from the tester alone.

    Raises:
        NotApplicable: the slave sends it, and cannot be told not to.
    """
    if tester.entry(SYNC_COB_ID) is not None:
        cob_id = tester.number(SYNC_COB_ID)
        if cob_id & identifiers.PRODUCES:
            tester.need_writable(SYNC_COB_ID)
            tester.write((SYNC_COB_ID, 0), cob_id & ~identifiers.PRODUCES)


def expect_none(tester: Tester, can_ids: Collection[int], when: str) -> None:
    """None of some TPDOs is sent, whether there is SYNC or it is asked for.

    Raises:
        Failed: one is.
    """
    tester.forget()
    tester.send(identifiers.SYNC)
    for can_id in can_ids:
        tester.send(can_id, remote=True)
    for frame in tester.listen(SILENCE):
        if frame.can_id in can_ids and not frame.remote:
            raise Failed(f"{frame} is sent {when}")


def _scan(tester: Tester, area: range) -> None:
    for index in need_records(tester, area):
        highest = max(entries_of(tester.slave.dictionary.indices[index]))
        if tester.number(index) > highest:
            raise Failed(f"0x{index:04X}:00 is {tester.number(index)}, there are {highest}")
        mapped = parts(tester, index + MAPPINGS)
        for address, _ in mapped:
            if address[0] not in DUMMY_TYPES and tester.entry(*address) is None:
                raise Failed(f"0x{index + MAPPINGS:04X} maps {address_text(address)}: not there")
        if sum(bits for _, bits in mapped) > LONGEST:
            raise Failed(f"0x{index + MAPPINGS:04X} maps more than 64 bits")


def _are_predefined(tester: Tester, area: range) -> None:
    need_records(tester, area)
    for pdo in valid(tester, area):
        if pdo.record < area.start + 4:
            number = pdo.record - area.start
            usual = PREDEFINED[area] + 0x100 * number + tester.slave.node_id
            if pdo.can_id != usual:
                raise Failed(f"0x{pdo.record:04X} has {pdo.can_id:03X} instead of {usual:03X}")


RECORDS = "CiA 301, 7.5.2.35"


@PDOS.topic(RECORDS)
def rpdos_are_sound(tester: Tester) -> None:
    """The records of RPDOs map what there is, and at most 64 bits."""
    _scan(tester, RPDOS)


@PDOS.topic("CiA 301, 7.5.2.37")
def tpdos_are_sound(tester: Tester) -> None:
    """The records of TPDOs map what there is, and at most 64 bits."""
    _scan(tester, TPDOS)


@PDOS.topic("CiA 301, 7.3.3")
def rpdos_are_predefined(tester: Tester) -> None:
    """The first four RPDOs have the identifiers of the predefined connection set."""
    _are_predefined(tester, RPDOS)


@PDOS.topic("CiA 301, 7.3.3")
def tpdos_are_predefined(tester: Tester) -> None:
    """The first four TPDOs have the identifiers of the predefined connection set."""
    _are_predefined(tester, TPDOS)


GROUPS = (PDOS,)
