"""Topics about storing and restoring parameters, and about identifiers that nobody may have."""

from collections.abc import Mapping

from canopen.objectdictionary.datatypes import INTEGER_TYPES

from canopen_twins.bus import identifiers
from canopen_twins.bus.sdo import Address
from canopen_twins.conform.pdo import COB_ID, RPDOS, TPDOS, need_records
from canopen_twins.conform.sdo import address_of
from canopen_twins.conform.tester import Failed, NotApplicable, Tester
from canopen_twins.conform.topic import Group
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.object import Abort

STORE = Group(8, "Storing and restricted identifiers", "sdo")

SAVE, RESTORE = 0x1010, 0x1011
SIGNATURES = {SAVE: b"save", RESTORE: b"load"}
WRONG_SIGNATURE = (0x08000020, 0x08000022, 0x08000000)
STORING, RESTORING = "CiA 301, 7.5.2.13", "CiA 301, 7.5.2.14"
RESTRICTED = (0x001, 0x101, 0x180, 0x5FF, 0x67F, 0x6E0, 0x701, 0x7FF)


def _tells_how(tester: Tester, index: int) -> None:
    tester.need(index, 1)
    if not tester.number(index, 1) & 3:
        raise Failed(f"0x{index:04X}:01 tells that it does nothing")


def _wants_signature(tester: Tester, index: int) -> None:
    tester.need(index, 1)
    wrong = int.from_bytes(SIGNATURES[index], "little") ^ 0x20
    tester.expect_refusal((index, 1), wrong, *WRONG_SIGNATURE)


def _command(tester: Tester, index: int) -> None:
    tester.need(index, 1)
    tester.write((index, 1), SIGNATURES[index])


OTHERS = {0x1017: 700, 0x1006: 700_000, 0x100C: 700, 0x1005: 0x6D0}
ENOUGH = 20  # entries that may be what is stored


def expect_stored(tester: Tester, others: Mapping[Address, int]) -> None:
    """One of some values at least outlives a reset of the node when it was stored.

    All have their old values again, and these are stored.

    Raises:
        NotApplicable: nothing can be stored.
    """
    tester.need(SAVE, 1)
    before = {address: tester.read(address) for address in others}
    for address, other in others.items():
        tester.write(address, other)
    _command(tester, SAVE)
    tester.reset()
    kept = [address for address, other in others.items() if tester.number(*address) == other]
    for address, value in before.items():
        tester.write(address, value)
    _command(tester, SAVE)
    if not kept:
        told = ", ".join(map(address_text, others))
        raise Failed(f"of what was stored nothing has its value again: {told}")


def _settable(tester: Tester) -> Mapping[Address, int]:
    """What may be stored, with other values that are taken.

    Raises:
        NotApplicable: there is nothing.
    """
    found = {}
    for entry in tester.entries():
        address = address_of(entry)
        if not (entry.readable and entry.writable and entry.data_type in INTEGER_TYPES):
            continue
        if entry.index in OTHERS or entry.pdo_mappable:  # neither is a node id or a bit rate
            before = tester.number(*address)
            other = OTHERS.get(entry.index, before ^ 1)
            if other != before and tester.try_write(address, other) == 0:
                found[address] = other
                tester.write(address, before)
        if len(found) == ENOUGH:
            break
    if not found:
        raise NotApplicable("there is nothing that could be stored", SAVE)
    return found


@STORE.topic(STORING)
def storing_is_told(tester: Tester) -> None:
    """0x1010 tells how parameters are stored."""
    _tells_how(tester, SAVE)


@STORE.topic(STORING)
def storing_wants_signature(tester: Tester) -> None:
    """Nothing is stored without the signature: 0800002xh."""
    _wants_signature(tester, SAVE)


@STORE.topic(STORING)
def parameters_are_stored(tester: Tester) -> None:
    """The signature stores: a value outlives a reset of the node."""
    tester.need(SAVE, 1)
    expect_stored(tester, _settable(tester))


@STORE.topic(RESTORING)
def restoring_is_told(tester: Tester) -> None:
    """0x1011 tells whether parameters are restored."""
    _tells_how(tester, RESTORE)


@STORE.topic(RESTORING)
def restoring_wants_signature(tester: Tester) -> None:
    """Nothing is restored without the signature: 0800002xh."""
    _wants_signature(tester, RESTORE)


@STORE.topic(RESTORING)
def parameters_are_restored(tester: Tester) -> None:
    """The signature restores: a value is that of the EDS after a reset of the node."""
    tester.need(RESTORE, 1)
    _command(tester, RESTORE)
    tester.reset()
    others = _settable(tester)
    defaults = {address: tester.read(address) for address in others}
    for address, other in others.items():
        tester.write(address, other)
    if tester.entry(SAVE, 1) is not None:
        _command(tester, SAVE)
    _command(tester, RESTORE)
    tester.reset()
    for address, default in defaults.items():
        if (now := tester.read(address)) != default:
            raise Failed(f"{address_text(address)} is {now.hex()} instead of {default.hex()}")


def _expect_restricted(tester: Tester, address: Address, flags: int = 0) -> None:
    tester.need_writable(*address)
    for can_id in RESTRICTED:
        tester.expect_refusal(address, can_id | flags, Abort.INVALID_VALUE)


@STORE.topic("CiA 301, 7.3.5")
def rpdo_gets_no_restricted_identifier(tester: Tester) -> None:
    """No RPDO takes a restricted identifier: 06090030h."""
    _expect_of_pdo(tester, RPDOS)


@STORE.topic("CiA 301, 7.3.5")
def tpdo_gets_no_restricted_identifier(tester: Tester) -> None:
    """No TPDO takes a restricted identifier: 06090030h."""
    _expect_of_pdo(tester, TPDOS)


def _expect_of_pdo(tester: Tester, area: range) -> None:
    index = need_records(tester, area)[0]
    tester.need_writable(index, COB_ID)
    cob_id = tester.number(index, COB_ID)
    tester.write((index, COB_ID), cob_id | identifiers.INVALID)
    _expect_restricted(tester, (index, COB_ID), cob_id & identifiers.NO_RTR)


@STORE.topic("CiA 301, 7.3.5")
def sync_gets_no_restricted_identifier(tester: Tester) -> None:
    """SYNC takes no restricted identifier: 06090030h."""
    _expect_restricted(tester, (0x1005, 0))


@STORE.topic("CiA 301, 7.3.5")
def emcy_gets_no_restricted_identifier(tester: Tester) -> None:
    """EMCY takes no restricted identifier: 06090030h."""
    tester.need_writable(0x1014)
    tester.write((0x1014, 0), tester.number(0x1014) | identifiers.INVALID)
    _expect_restricted(tester, (0x1014, 0))


GROUPS = (STORE,)
