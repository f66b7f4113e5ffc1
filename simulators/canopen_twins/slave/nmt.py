"""NMT slave: follows the master's commands; a reset it leaves to the node (CiA 301, 7.2.8)."""

from collections.abc import Mapping
from enum import IntEnum

from canopen_twins.bus.frame import Frame
from canopen_twins.slave.service import Listening, Service, State
from canopen_twins.slave.slave import Slave

ALL_NODES = 0
TARGET: Mapping[int, State] = {
    0x01: State.OPERATIONAL,
    0x02: State.STOPPED,
    0x80: State.PRE_OPERATIONAL,
}


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

    def listen(self) -> Listening:
        """Commands of the NMT master."""
        yield (0x000, False), self.on_command

    def on_state(self, state: State) -> None:
        """Kept for whoever asks afterwards why something was not answered."""
        self.slave.wire.diary.enter(state)

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

    def boot_up(self) -> None:
        """Announce that initialisation is over."""
        self.slave.wire.put(Frame(0x700 + self.slave.node_id, b"\0"))
