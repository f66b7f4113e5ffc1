"""COB-IDs in the dictionary: their bits, and which values CiA 301 lets them take (7.3.5)."""

from collections.abc import Iterable

from canopen_twins.slave.object import Rejected

INVALID = 1 << 31  # of a PDO: does not exist; of an EMCY likewise
NO_RTR = 1 << 30  # of a TPDO: may not be asked for; of SYNC: the node produces it
CAN_ID = 0x7FF
RESERVED = 0x3FFFF800  # bit 29 is for 29-bit identifiers, which none of the devices knows

RESTRICTED: Iterable[range] = (
    range(0x080),
    range(0x101, 0x181),
    range(0x581, 0x600),
    range(0x601, 0x680),
    range(0x6E0, 0x700),
    range(0x701, 0x800),
)


def check(value: int) -> None:
    """Raises `Rejected` if a COB-ID names no identifier, or one in use by another service."""
    if value & RESERVED:
        raise Rejected(f"{value:08X}h: identifiers have 11 bits")
    if not value & INVALID and any(value & CAN_ID in ids for ids in RESTRICTED):
        raise Rejected(f"{value & CAN_ID:03X}h belongs to another service")


def check_change(before: int, value: int, *, strict: bool = False) -> None:
    """Raises `Rejected` if more than bit 31 changes while it is 0 before and after the write.

    `strict` wants it to be 1 before.
    """
    changed = (before ^ value) & ~INVALID
    if changed and not before & INVALID and (strict or not value & INVALID):
        raise Rejected("bit 31 has to be set before the identifier changes")
    check(value)
