"""Network management (CiA 301, 7.2.8): the NMT slave and its boot-up message."""

from collections.abc import Mapping
from enum import IntEnum

from canopen_twins.bus import identifiers
from canopen_twins.bus.frame import Frame
from canopen_twins.slave.object import Address, Object, Rejected
from canopen_twins.slave.service import Listening, Service, State
from canopen_twins.slave.slave import Slave

ALL_NODES = 0
TARGET: Mapping[int, State] = {
    0x01: State.OPERATIONAL,
    0x02: State.STOPPED,
    0x80: State.PRE_OPERATIONAL,
}
WAITS_FOR_START = 1 << 2  # bit of 0x1F80


class Reset(IntEnum):
    """Command specifiers that end in Initialisation."""

    NODE = 0x81
    COMMUNICATION = 0x82


RESETS: Mapping[int, Reset] = {reset.value: reset for reset in Reset}


class Nmt(Service):
    """`state` and `reset` are read by the node after every frame.

    A device that enters a state by itself sets `state` as the master would.
    """

    def __init__(self, slave: Slave) -> None:
        super().__init__(slave)
        self.state = State.PRE_OPERATIONAL
        self.reset: Reset | None = None

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Of the NMT start-up only what a slave knows can be written."""
        return {(0x1F80, 0): Object(write=self._check)} if self.slave.has(0x1F80) else {}

    @property
    def starts_by_itself(self) -> bool:
        """Whether Operational follows on the boot-up without a command (CiA 302-2, 0x1F80)."""
        return self.slave.has(0x1F80) and not self.slave.number(0x1F80) & WAITS_FOR_START

    def listen(self) -> Listening:
        """Commands of the NMT master."""
        yield (identifiers.NMT, False), self.on_command

    def on_state(self, state: State) -> None:
        """Kept for whoever asks afterwards why something was not answered."""
        self.slave.wire.events.add_state(state)

    def on_command(self, frame: Frame) -> None:
        """Obey if the length is right and the command meant for this node or for all."""
        if len(frame.data) not in self.slave.profile.nmt_lengths:
            return
        command, target = frame.data[:2]
        if target not in (ALL_NODES, self.slave.node_id):
            return
        if command in TARGET:
            self.state = TARGET[command]
        elif command in RESETS:
            self.state, self.reset = State.INITIALISING, RESETS[command]

    def _check(self, value: int) -> None:
        if value & ~WAITS_FOR_START:
            raise Rejected(f"{value:08X}h: a slave knows bit 2 only")

    def boot_up(self) -> None:
        """Announce that initialisation is over."""
        self.slave.send(Frame(identifiers.heartbeat(self.slave.node_id), BOOT_UP))


BOOT_UP = b"\0"
STATE_BYTE = {
    State.STOPPED: 0x04,
    State.OPERATIONAL: 0x05,
    State.PRE_OPERATIONAL: 0x7F,
}
"""What a heartbeat shows."""
