"""Topics about the EDS and about the object dictionary, which has to be what the EDS says."""

from collections.abc import Iterator
from typing import Any

from canopen.objectdictionary import ODVariable

from canopen_twins.bus import sdo
from canopen_twins.bus.sdo import Ccs
from canopen_twins.conform.sdo import COMMANDS, above, address_of, below
from canopen_twins.conform.tester import Failed, NotApplicable, Tester
from canopen_twins.conform.topic import Group
from canopen_twins.scenario.sdo_client import ACCEPTED, upload
from canopen_twins.slave.dictionary import address_text, read
from canopen_twins.slave.object import DUMMY_TYPES, Abort, entries_of

EDS = Group(1, "EDS", "states")
DICTIONARY = Group(4, "Object dictionary", "sdo")

MANDATORY = ((0x1000, 0), (0x1001, 0), (0x1018, 0), (0x1018, 1))
OPTIONAL = range(0x1002, 0x1030)  # of CiA 301
COMMUNICATION = range(0x1000, 0x2000)
MAPPINGS = (*range(0x1600, 0x1800), *range(0x1A00, 0x1C00))  # while the PDO is off only
NOT_NOW = range(0x08000020, 0x08000023)  # abort codes: as the device is, not for the value
CODES = "CiA 301, 7.2.4.3.17"


def _entries(tester: Tester) -> Iterator[ODVariable]:
    return (entry for entry in tester.entries() if entry.index not in DUMMY_TYPES)


def _all(found: list[str]) -> None:
    """Raises `Failed` with what was found, if anything was."""
    if found:
        more = f" and {len(found) - 3} more" if len(found) > 3 else ""
        raise Failed("; ".join(found[:3]) + more)


@EDS.topic("CiA 306")
def eds_is_sound(tester: Tester) -> None:
    """The EDS is as CiA 306 wants it, and has what every device has."""
    missing = [address for address in MANDATORY if tester.entry(*address) is None]
    remarks = [remark.told(tester.slave.eds) for remark in read(tester.slave.eds).remarks]
    _all([f"there is no {address_text(address)}" for address in missing] + remarks)


@DICTIONARY.topic("CiA 301, 7.4.1")
def everything_can_be_read(tester: Tester) -> None:
    """Every entry that may be read can be, and has the length of its type."""
    found = []
    for entry in _entries(tester):
        if entry.readable:
            answer = tester.transfer(upload(address_of(entry)))
            codec = entry.STRUCT_TYPES.get(entry.data_type or 0)
            where = address_text(address_of(entry))
            if answer.code != ACCEPTED:
                found.append(f"{where} is refused with {answer.code:08X}h")
            elif codec is not None and len(answer.data) != codec.size:
                found.append(f"{where} has {len(answer.data)} bytes instead of {codec.size}")
    _all(found)


@DICTIONARY.topic(CODES)
def nothing_write_only_can_be_read(tester: Tester) -> None:
    """No entry that is write-only can be read: 06010001h."""
    closed = [entry for entry in _entries(tester) if not entry.readable]
    if not closed:
        raise NotApplicable("nothing is write-only")
    for entry in closed:
        answer = tester.ask(sdo.message(Ccs.UPLOAD, sdo.multiplexer(address_of(entry))))
        tester.expect_abort(answer, address_text(address_of(entry)), Abort.WRITE_ONLY)


@DICTIONARY.topic(CODES)
def nothing_read_only_can_be_written(tester: Tester) -> None:
    """No entry that is read-only or constant can be written: 06010002h."""
    for entry in _entries(tester):
        if not entry.writable and entry.data_type in entry.STRUCT_TYPES:
            value = bytes(tester.size(address_of(entry)))
            tester.expect_refusal(address_of(entry), value, Abort.READ_ONLY)


@DICTIONARY.topic("CiA 306")
def defaults_are_as_in_the_eds(tester: Tester) -> None:
    """What no PDO carries has the default value of the EDS after a reset."""
    found = []
    for entry in _entries(tester):
        default: Any = entry.default
        known = default is not None and entry.data_type in entry.STRUCT_TYPES
        if known and entry.readable and not entry.pdo_mappable and entry.index not in COMMANDS:
            value = tester.read(address_of(entry))
            if value != entry.encode_raw(default):
                where = address_text(address_of(entry))
                found.append(
                    f"{where} is {value.hex()} instead of {entry.encode_raw(default).hex()}"
                )
    _all(found)


@DICTIONARY.topic(CODES)
def high_limits_hold(tester: Tester) -> None:
    """No entry takes a value above its high limit: 06090030h or 06090031h."""
    limited = [(entry, value) for entry in _entries(tester) if (value := above(entry)) is not None]
    _expect_limits(tester, limited, Abort.TOO_HIGH)


@DICTIONARY.topic(CODES)
def low_limits_hold(tester: Tester) -> None:
    """No entry takes a value below its low limit: 06090030h or 06090032h."""
    limited = [(entry, value) for entry in _entries(tester) if (value := below(entry)) is not None]
    _expect_limits(tester, limited, Abort.TOO_LOW)


def _expect_limits(tester: Tester, limited: list[tuple[ODVariable, bytes]], code: int) -> None:
    if not limited:
        raise NotApplicable("no entry that can be written has such a limit")
    for entry, value in limited:
        tester.expect_refusal(address_of(entry), value, Abort.INVALID_VALUE, code)


@DICTIONARY.topic("CiA 301, 7.4.1")
def values_are_taken_back(tester: Tester) -> None:
    """Every entry that can be read and written takes the value that it has, but for mappings."""
    found = []
    for entry in _entries(tester):
        may = entry.readable and entry.writable and entry.index not in (*COMMANDS, *MAPPINGS)
        if may and entry.data_type in entry.STRUCT_TYPES:
            address = address_of(entry)
            code = tester.try_write(address, tester.read(address))
            if code and code not in NOT_NOW:
                found.append(f"{address_text(address)} is refused with {code:08X}h")
    _all(found)


@DICTIONARY.topic("CiA 301, 7.4.6")
def highest_subindex_is_told(tester: Tester) -> None:
    """Sub-index 0 of an array or a record is the highest that there is, or lower."""
    found = []
    for index in sorted(tester.slave.dictionary.indices):
        entries = entries_of(tester.slave.dictionary.indices[index])
        if len(entries) > 1 and 0 in entries and entries[0].readable:
            told, highest = tester.number(index), max(entries)
            if told > highest:
                found.append(f"0x{index:04X}:00 is {told}, there are {highest}")
    _all(found)


@DICTIONARY.topic(CODES)
def nothing_else_is_there(tester: Tester) -> None:
    """Objects of CiA 301 that the EDS does not have are not there: 06020000h."""
    for index in OPTIONAL:
        if index not in tester.slave.dictionary.indices:
            answer = tester.ask(sdo.message(Ccs.UPLOAD, sdo.multiplexer((index, 0))))
            tester.expect_abort(answer, f"reading 0x{index:04X}", Abort.NO_OBJECT)


GROUPS = (EDS, DICTIONARY)
