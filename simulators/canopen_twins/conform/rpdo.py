"""Topics about RPDOs, when their values are taken over and when not, and about mapping."""

from typing import NamedTuple

from canopen.objectdictionary import ODVariable

from canopen_twins.bus import identifiers
from canopen_twins.bus.sdo import Address
from canopen_twins.conform.pdo import (
    COB_ID,
    LONGEST,
    MAPPINGS,
    RPDOS,
    TPDOS,
    Pdo,
    obtain,
    parts,
    produce_sync,
    records,
    switch_off,
    valid,
)
from canopen_twins.conform.tester import (
    ENTER_PRE_OPERATIONAL,
    START,
    STOP,
    Failed,
    NotApplicable,
    Tester,
)
from canopen_twins.conform.topic import Group
from canopen_twins.conform.tpdo import expect_reserved_refused
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.object import DUMMY_TYPES, Abort

RPDO = Group(3, "PDO", "pdo")

TYPES, RULES, MAPPING = "CiA 301, 7.2.2.2", "CiA 301, 7.5.2.35", "CiA 301, 7.5.2.36"
STATES = "CiA 301, 7.3.2.2.5"
SYNCHRONOUS = range(241)
ANY = [254, 255]


class Target(NamedTuple):
    """A value that an RPDO can change, and that tells whether it has."""

    pdo: Pdo
    address: Address
    before: bytes
    data: bytes
    """Of a frame that changes it, and nothing else."""

    def expect(self, tester: Tester, taken: bool, when: str) -> None:
        """Raises `Failed` if the value is not as it should be."""
        if (tester.read(self.address) != self.before) is not taken:
            raise Failed(f"{self.pdo.can_id:03X} is {'not ' if taken else ''}taken {when}")


def _target(tester: Tester, types: range | list[int]) -> Target:
    """Raises `NotApplicable` if what RPDOs carry cannot be read, or no RPDO has such a type."""
    pdo = obtain(tester, RPDOS, types)
    value, place, found = 0, 0, None
    for address, bits in pdo.parts:
        entry = None if address[0] in DUMMY_TYPES else tester.entry(*address)
        if entry is not None and entry.readable and entry.data_type in entry.STRUCT_TYPES:
            before = tester.read(address)
            now = int.from_bytes(before, "little")
            if found is None and 8 * len(before) == bits == 8 * tester.size(address):
                found = address, before
                now = _other(entry, before)
            value |= (now & (1 << bits) - 1) << place
        place += bits
    if found is None:
        raise NotApplicable("nothing that RPDOs carry can be read", RPDOS.start)
    return Target(pdo, *found, value.to_bytes(pdo.size, "little"))


def _other(entry: ODVariable, before: bytes) -> int:
    """A value beside the one there is, within the limits of the dictionary."""
    now = int.from_bytes(before, "little")
    (value,) = entry.STRUCT_TYPES[entry.data_type or 0].unpack(before)
    highest = entry.max is not None and value >= entry.max
    return now - 1 if highest or now == (1 << 8 * len(before)) - 1 else now + 1


@RPDO.topic(TYPES)
def is_taken_at_once(tester: Tester) -> None:
    """An event-driven RPDO is taken at once."""
    target = _target(tester, ANY)
    tester.nmt(START)
    tester.send(target.pdo.can_id, target.data)
    target.expect(tester, True, "without SYNC")


@RPDO.topic(TYPES)
def is_taken_at_sync(tester: Tester) -> None:
    """A synchronous RPDO is taken at the next SYNC, and not before."""
    target = _target(tester, SYNCHRONOUS)
    produce_sync(tester)
    tester.nmt(START)
    tester.send(target.pdo.can_id, target.data)
    target.expect(tester, False, "before SYNC")
    tester.send(identifiers.SYNC)
    target.expect(tester, True, "at SYNC")


@RPDO.topic(STATES)
def is_not_taken_in_pre_operational(tester: Tester) -> None:
    """No RPDO is taken in Pre-operational."""
    target = _target(tester, ANY)
    tester.send(target.pdo.can_id, target.data)
    target.expect(tester, False, "in pre-operational")


@RPDO.topic(STATES)
def is_not_taken_in_stopped(tester: Tester) -> None:
    """No RPDO is taken in Stopped."""
    target = _target(tester, ANY)
    tester.nmt(STOP)
    tester.send(target.pdo.can_id, target.data)
    tester.nmt(ENTER_PRE_OPERATIONAL)
    target.expect(tester, False, "in stopped")


@RPDO.topic("CiA 301, 7.2.2.6")
def is_not_taken_when_short(tester: Tester) -> None:
    """An RPDO that is shorter than its mapping is not taken."""
    target = _target(tester, ANY)
    tester.nmt(START)
    tester.send(target.pdo.can_id, target.data[:-1])
    target.expect(tester, False, "though it is too short")


@RPDO.topic("CiA 301, 7.2.2.6")
def is_taken_when_long(tester: Tester) -> None:
    """Of an RPDO that is longer than its mapping the first bytes are taken."""
    target = _target(tester, ANY)
    if target.pdo.size == 8:
        raise NotApplicable("its mapping has eight bytes", target.pdo.mapping)
    tester.nmt(START)
    tester.send(target.pdo.can_id, target.data + b"\0")
    target.expect(tester, True, "when it is longer")


@RPDO.topic(RULES)
def is_switched_off(tester: Tester) -> None:
    """An RPDO with bit 31 of its COB-ID set is not taken."""
    target = _target(tester, ANY)
    switch_off(tester, target.pdo)
    tester.nmt(START)
    tester.send(target.pdo.can_id, target.data)
    target.expect(tester, False, "with bit 31")


@RPDO.topic(RULES)
def takes_other_identifier(tester: Tester) -> None:
    """An RPDO is taken with another identifier when it has got one."""
    target = _target(tester, ANY)
    cob_id = switch_off(tester, target.pdo)
    tester.write((target.pdo.record, COB_ID), cob_id & ~identifiers.CAN_ID | 0x6D0)
    tester.nmt(START)
    tester.send(target.pdo.can_id, target.data)
    target.expect(tester, False, "with its old identifier")
    tester.send(0x6D0, target.data)
    if tester.read(target.address) == target.before:
        raise Failed("6D0 is not taken, which was set")


@RPDO.topic(RULES)
def refuses_reserved_types(tester: Tester) -> None:
    """Transmission types 241 to 251 of an RPDO are refused: 06090030h."""
    expect_reserved_refused(tester, RPDOS)


@RPDO.topic(RULES)
def keeps_its_identifier(tester: Tester) -> None:
    """The identifier of a PDO in force cannot be changed: 06090030h."""
    pdos = [*valid(tester, RPDOS), *valid(tester, TPDOS)]
    if not pdos:
        raise NotApplicable("no PDO is in force", RPDOS.start)
    for pdo in pdos:
        tester.need_writable(pdo.record, COB_ID)
        cob_id = tester.number(pdo.record, COB_ID)
        tester.expect_refusal((pdo.record, COB_ID), cob_id ^ 1, Abort.INVALID_VALUE)


def _cleared(tester: Tester) -> Pdo:
    """A PDO whose mapping has been made empty; it was as it is told.

    Raises:
        NotApplicable: no mapping can be written.
    """
    for index in (*records(tester, TPDOS), *records(tester, RPDOS)):
        mapping = index + MAPPINGS
        count, first = tester.entry(mapping), tester.entry(mapping, 1)
        mapped = parts(tester, mapping)
        if mapped and count is not None and count.writable and first and first.writable:
            pdo = Pdo(index, tester.number(index, COB_ID) & identifiers.CAN_ID, mapped)
            switch_off(tester, pdo)
            tester.write((mapping, 0), 0)
            return pdo
    raise NotApplicable("no mapping can be written", TPDOS.start + MAPPINGS)


def _value(address: Address, bits: int) -> int:
    return address[0] << 16 | address[1] << 8 | bits


@RPDO.topic(MAPPING)
def is_mapped_anew(tester: Tester) -> None:
    """A mapping is changed: bit 31, no entries, entries, their number, and no bit 31."""
    pdo = _cleared(tester)
    address, bits = pdo.parts[-1]
    tester.write((pdo.mapping, 1), _value(address, bits))
    tester.write((pdo.mapping, 0), 1)
    tester.write((pdo.record, COB_ID), pdo.can_id)
    if parts(tester, pdo.mapping) != ((address, bits),):
        raise Failed(f"0x{pdo.mapping:04X} does not have what was written")


@RPDO.topic(MAPPING)
def refuses_too_much(tester: Tester) -> None:
    """More than 64 bits, or more parts than there are entries, are refused: 06040042h."""
    pdo = _cleared(tester)
    address, bits = max(pdo.parts, key=lambda part: part[1])
    subindex = 0
    while tester.entry(pdo.mapping, subindex + 1) is not None and subindex * bits <= LONGEST:
        subindex += 1
        code = tester.try_write((pdo.mapping, subindex), _value(address, bits))
        if code:
            tester.expect_code(code, f"part {subindex}", Abort.PDO_TOO_LONG)
            return
    if subindex * bits <= LONGEST:
        subindex += 1
    codes = (Abort.PDO_TOO_LONG, Abort.INVALID_VALUE, Abort.TOO_HIGH)
    tester.expect_refusal((pdo.mapping, 0), subindex, *codes)


@RPDO.topic(MAPPING)
def refuses_what_cannot_be_mapped(tester: Tester) -> None:
    """What cannot be mapped or is not there is refused: 06040041h or 06020000h."""
    pdo = _cleared(tester)
    for address, codes in (
        ((0x1000, 0), (Abort.NOT_MAPPABLE,)),
        ((0x1004, 0), (Abort.NO_OBJECT, Abort.NOT_MAPPABLE)),
    ):
        code = tester.try_write((pdo.mapping, 1), _value(address, 32))
        code = code or tester.try_write((pdo.mapping, 0), 1)
        tester.expect_code(code, f"mapping {address_text(address)}", *codes)


GROUPS = (RPDO,)
