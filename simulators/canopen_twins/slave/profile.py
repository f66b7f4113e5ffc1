"""In which points a device's communication differs from what CiA 301 leaves open."""

from collections.abc import Callable, Container
from dataclasses import dataclass

from canopen_twins.slave.object import Abort

DATA_LENGTHS = range(2, 3)


def exact_period(milliseconds: int) -> float:
    """The heartbeat period as written to 0x1017, in seconds."""
    return milliseconds / 1000


@dataclass(frozen=True)
class Profile:
    """The defaults are what CiA 301 recommends; a device names what its manual says otherwise."""

    segmented: bool = True
    """Whether the SDO server offers segmented transfer."""
    block: bool = False
    """Whether the SDO server offers block transfer; refused with 0504 0001h otherwise."""
    literal_commands: bool = False
    """Whether 2xh, 40h and 80h are the only SDO command bytes known (no reserved bits ignored)."""
    length_before_access: bool = False
    """Whether a write is checked for its length before it is checked for being allowed."""
    too_long: int = Abort.TOO_LONG
    """Abort code for more data than the object has room for."""
    too_short: int = Abort.TOO_SHORT
    """Abort code for less data than the object has room for."""
    transfer_time_out: float = 10.0
    """Seconds after which a transfer that nobody continues is aborted."""
    longest_transfer: int = 4096
    """Bytes a download of an object without a fixed length may carry."""
    nmt_lengths: Container[int] = DATA_LENGTHS
    """Data lengths with which an NMT command is obeyed."""
    heartbeat_period: Callable[[int], float] = exact_period
    """Seconds between two heartbeats for a value of 0x1017 that is not 0."""
    first_heartbeat_at_once: bool = False
    """Whether writing 0x1017 sends a heartbeat; the first comes a period later otherwise."""
    rpdo_types: Container[int] = frozenset({*range(241), 254, 255})
    """Transmission types that an RPDO accepts."""
    tpdo_types: Container[int] = frozenset({*range(241), 252, 253, 254, 255})
    """Transmission types that a TPDO accepts."""
    tpdo_on_change: bool = True
    """Whether an event-driven TPDO (254, 255) is sent when its content has changed."""
    tells_bus_errors: bool = False
    """Whether errors of its CAN controller, and a silent node of 0x1016, are told by EMCY (8120h,
    8130h, 8140h) and act as 0x1029 says; else a device tells what its manual does of them."""
    no_history_code: int | None = None
    """Abort code for an unused entry of 0x1003; it reads 0 without one."""
    strict_cob_id: bool = False
    """Whether a new COB-ID needs two writes, bit 31 first, and bit 30 of an RPDO as it is."""
    store_signature: bool = True
    """Whether 0x1010 and 0x1011 want their signature; any value does otherwise."""
    store_code: int = Abort.NOT_TRANSFERABLE
    """Abort code for a wrong signature in 0x1010 and 0x1011."""
    restore_at_once: bool = False
    """Whether 0x1011 acts at once; after the next reset otherwise."""
