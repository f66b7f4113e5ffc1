"""Communication services (CiA 301, 305): what a slave does besides answering for its objects."""

from collections.abc import Callable, Iterable, Mapping
from enum import StrEnum

from canopen_twins.bus.frame import Frame
from canopen_twins.slave.object import Address, Object
from canopen_twins.slave.slave import Slave

NODE_IDS = range(1, 128)  # CiA 301, 7.2.4.3.1

Handler = Callable[[Frame], None]
Heard = tuple[int, bool]
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
