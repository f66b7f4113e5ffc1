"""Identifiers: whose frame it is by the predefined connection set (CiA 301, 7.3.3), and COB-IDs.

Identifiers of PDOs, EMCY and SYNC can be changed in the dictionary of a node; who wants to know
what they are now asks its `slave`.
"""

from enum import StrEnum
from typing import NamedTuple

NODE_IDS = range(1, 128)  # 7.2.4.3.1
UNCONFIGURED = 255  # of a node that has no node id yet (CiA 305)

NMT, SYNC, TIME = 0x000, 0x080, 0x100
LSS_ANSWER, LSS_REQUEST = 0x7E4, 0x7E5  # CiA 305

# Bits of a COB-ID in the dictionary
INVALID = 1 << 31  # the PDO or EMCY does not exist
NO_RTR = 1 << 30  # a TPDO that may not be asked for
PRODUCES = 1 << 30  # SYNC comes from this node
RESERVED = 0x3FFFF800  # 0 if the identifier has 11 bits; no device here knows those of 29
CAN_ID = 0x7FF  # the identifier


class Cob(StrEnum):
    """Communication objects: what a frame is."""

    NMT = "NMT"
    SYNC = "SYNC"
    TIME = "TIME"
    EMCY = "EMCY"
    TPDO = "TPDO"
    RPDO = "RPDO"
    SDO_ANSWER = "SDO answer"
    SDO_REQUEST = "SDO request"
    HEARTBEAT = "heartbeat"
    LSS_ANSWER = "LSS answer"
    LSS_REQUEST = "LSS request"


class Identifier(NamedTuple):
    """What an identifier stands for; the node id is 0 where no node has it for itself."""

    cob: Cob
    node_id: int = 0


_BROADCAST = {
    NMT: Identifier(Cob.NMT),
    SYNC: Identifier(Cob.SYNC),
    TIME: Identifier(Cob.TIME),
    LSS_ANSWER: Identifier(Cob.LSS_ANSWER),
    LSS_REQUEST: Identifier(Cob.LSS_REQUEST),
}
_BASES = {
    0x080: Cob.EMCY,
    **dict.fromkeys((0x180, 0x280, 0x380, 0x480), Cob.TPDO),
    **dict.fromkeys((0x200, 0x300, 0x400, 0x500), Cob.RPDO),
    0x580: Cob.SDO_ANSWER,
    0x600: Cob.SDO_REQUEST,
    0x700: Cob.HEARTBEAT,  # and the boot-up message, and the answers to node guarding
}
_BASE, _NODE_ID = 0x780, 0x7F


def classify(can_id: int) -> Identifier | None:
    """What an 11-bit identifier stands for in the predefined connection set; none for nothing."""
    if (broadcast := _BROADCAST.get(can_id)) is not None:
        return broadcast
    cob, node_id = _BASES.get(can_id & _BASE), can_id & _NODE_ID
    return Identifier(cob, node_id) if cob is not None and node_id else None


def emcy(node_id: int) -> int:
    """The identifier of the emergencies of a node, unless its dictionary says otherwise."""
    return 0x080 + node_id


def sdo_answer(node_id: int) -> int:
    """The identifier from the SDO server of a node to its client."""
    return 0x580 + node_id


def sdo_request(node_id: int) -> int:
    """The identifier from a client to the SDO server of a node."""
    return 0x600 + node_id


def heartbeat(node_id: int) -> int:
    """The identifier of heartbeat and boot-up, and of node guarding."""
    return 0x700 + node_id


def of_cob_id(value: int) -> int | None:
    """The identifier of a COB-ID in the dictionary; none if bit 31 says that there is none."""
    return None if value & INVALID else value & CAN_ID


_RESTRICTED = (
    range(0x080),
    range(0x101, 0x181),
    range(0x581, 0x600),
    range(0x601, 0x680),
    range(0x6E0, 0x700),
    range(0x701, 0x800),
)


def is_restricted(can_id: int) -> bool:
    """Whether no PDO, SYNC or EMCY may be given this identifier (7.3.5)."""
    return any(can_id in ids for ids in _RESTRICTED)
