"""Communication services (CiA 301, 305): what a slave does besides answering for its objects."""

from collections.abc import Callable, Iterable, Mapping
from enum import StrEnum

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import CAN_ID, INVALID, RESERVED, is_restricted
from canopen_twins.bus.wire import Heard
from canopen_twins.slave.object import Address, Object, Rejected
from canopen_twins.slave.slave import Slave

Handler = Callable[[Frame], bool | None]
"""Takes a frame; true if that was no more than a look: device and dictionary are as before."""

Listening = Iterable[tuple[Heard, Handler]]


class State(StrEnum):
    """NMT states, by the names canopen gives them."""

    INITIALISING = "INITIALISING"
    PRE_OPERATIONAL = "PRE-OPERATIONAL"
    OPERATIONAL = "OPERATIONAL"
    STOPPED = "STOPPED"


class Service:
    """Says in which states it works, which frames it hears and which objects it answers for.

    A service lives as long as its slave: a reset makes both anew.
    """

    active_in = frozenset({State.PRE_OPERATIONAL, State.OPERATIONAL, State.STOPPED})
    any_type = False
    """Whether it takes objects of the standard of any type; else only integers are its own."""

    def __init__(self, slave: Slave) -> None:
        self.slave = slave

    @property
    def objects(self) -> Mapping[Address, Object]:
        """The entries this service answers for."""
        return {}

    @property
    def eventful(self) -> bool:
        """Whether `publish` may have something to say."""
        return False

    def listen(self) -> Listening:
        """Take the dictionary as it is now: pairs of (COB-ID, remote) and handler.

        Called after a boot-up and after every write to 0x1000-0x1FFF, so that frames and events
        find everything worked out.
        """
        return ()

    def on_state(self, state: State) -> None:
        """The node has entered an NMT state."""

    def publish(self) -> None:
        """Called after every frame and every step while active: send what is new."""


def give_default(slave: Slave, address: Address, value: int) -> None:
    """Give an entry that the file leaves without a number the one that the standard has for it."""
    entry = slave.entries.get(address[0], {}).get(address[1])
    if entry is None or not entry.is_whole:
        return
    if entry.variable.default is None and entry.variable.value is None:
        entry.write(entry.pack(value))


def check_cob_id(value: int) -> None:
    """Raises `Rejected` if a COB-ID names no identifier, or one of another service (7.3.5)."""
    if value & RESERVED:
        raise Rejected(f"{value:08X}h: identifiers have 11 bits")
    if not value & INVALID and is_restricted(value & CAN_ID):
        raise Rejected(f"{value & CAN_ID:03X}h belongs to another service")


def check_cob_id_change(before: int, value: int, *, strict: bool = False) -> None:
    """Raises `Rejected` if more than bit 31 changes while it is 0 before and after the write.

    `strict` wants it to be 1 before.
    """
    changed = (before ^ value) & ~INVALID
    if changed and not before & INVALID and (strict or not value & INVALID):
        raise Rejected("bit 31 has to be set before the identifier changes")
    check_cob_id(value)
