"""SDO faults: they strike the accesses to an object, at the initiate or in a segment."""

from __future__ import annotations

from typing import Any

from simulators.frame import Frame
from simulators.mischief.aim import Aim
from simulators.mischief.conversation import ABORT, Conversation
from simulators.mischief.disturbance import Filtering, Place, Side
from simulators.mischief.effects import Effect, altered, lost
from simulators.mischief.turn import Turn
from simulators.node import Node
from simulators.services import State
from simulators.services.sdo import REQUEST_LENGTH, SdoServer
from simulators.wire import Onward

TOGGLE = 0x10


def is_request(node: Node, frame: Frame) -> bool:
    """Whether a frame asks the SDO server of a node."""
    mine = (frame.can_id, frame.remote) == (0x600 + node.node_id, False)
    return mine and len(frame.data) == REQUEST_LENGTH


def is_answer(node: Node, frame: Frame) -> bool:
    """Whether a frame comes from the SDO server of a node."""
    return frame.can_id == 0x580 + node.node_id and len(frame.data) == REQUEST_LENGTH


class SdoFilter(Filtering):
    """Aims at requests and strikes the answers to them."""

    both_ways = True
    states = SdoServer.active_in

    def __init__(
        self,
        place: Place,
        effect: Effect = lost,
        object: int | str = "any",
        access: str = "any",
        segment: int = 0,
        **turn: Any,
    ) -> None:
        super().__init__(place.node, is_answer, effect, Turn(**turn))
        self._aim = Aim.at(place.node.device.dictionary(), object, access, segment)
        self._conversation = Conversation()
        self._struck = False

    def __call__(self, frame: Frame, onward: Onward) -> None:
        """Requests come in and answers go out through here."""
        if not self._running:
            onward(frame)
        elif is_answer(self.node, frame):
            self._conversation.answer(frame.data)
            act = self.strike if self._struck else _pass
            act(frame, onward)
        elif is_request(self.node, frame) and self.node.state in self.states:
            self._conversation.ask(frame.data)
            self._struck = self._hits()
            act = self.on_request if self._struck else _pass
            if self._struck:
                self.note(frame)
            act(frame, onward)
        else:
            onward(frame)

    def _hits(self) -> bool:
        return self._aim.hits(self._conversation) and self._turn.strikes()

    def on_request(self, frame: Frame, onward: Onward) -> None:
        """A request is struck: the server has it all the same."""
        onward(frame)


class Stall(SdoFilter):
    """Goes on until the transfer it has struck is over."""

    def _hits(self) -> bool:
        return (self._struck and self._conversation.segment > 0) or super()._hits()


class Refusal(SdoFilter):
    """Aborts instead of the server, for which the access never came."""

    side = Side.DEVICE

    def __init__(self, place: Place, code: int, **aim: Any) -> None:
        super().__init__(place, **aim)
        self._code = code.to_bytes(4, "little")

    def on_request(self, frame: Frame, onward: Onward) -> None:
        """The server hears instead that the client has given up what was open."""
        address = self._conversation.address
        onward(frame._replace(data=bytes([ABORT]) + bytes(7)))
        self._struck = False
        self._conversation.ask(bytes([ABORT]))
        if address is not None:
            multiplexer = address[0].to_bytes(2, "little") + bytes([address[1]])
            data = bytes([ABORT]) + multiplexer + self._code
            self.node.wire.put(Frame(0x580 + self.node.node_id, data))


class Unlocked(Stall):
    """Answers with a server of its own where the node has none."""

    side = Side.DEVICE
    states = frozenset({State.STOPPED})
    _server: SdoServer | None = None

    def on_request(self, frame: Frame, onward: Onward) -> None:
        """As in the states in which it may."""
        slave = self.node.slave
        if slave is None:
            return
        if self._server is None or self._server.slave is not slave:
            self._server = SdoServer(slave)
        with self.node.acting():
            self._server.on_request(frame)

    def stop(self) -> None:
        """Give up what is open."""
        super().stop()
        if self._server is not None:
            self._server.on_state(State.STOPPED)

    def strike(self, frame: Frame, onward: Onward) -> None:
        """The answer goes out as it is."""
        onward(frame)


def _pass(frame: Frame, onward: Onward) -> None:
    onward(frame)


def other_index(data: bytes) -> bytes:
    """The answer, about the object at the next index."""
    index = int.from_bytes(data[1:3], "little") + 1
    return data[:1] + (index & 0xFFFF).to_bytes(2, "little") + data[3:]


def other_toggle(data: bytes) -> bytes:
    """The answer to a segment, with the toggle bit the other way round."""
    return data if data[0] == ABORT else bytes([data[0] ^ TOGGLE]) + data[1:]


def other_size(by: int) -> Effect:
    """The answer to a read, with another size than its data have."""

    def change(data: bytes) -> bytes:
        if data[0] & 0xE3 == 0x43:  # expedited: 1..4 bytes, round the corner
            size = (3 - (data[0] >> 2 & 3) + by) % 4 + 1
            return bytes([0x43 | 4 - size << 2]) + data[1:]
        if data[0] == 0x41:
            size = int.from_bytes(data[4:], "little") + by
            return data[:4] + (size % (1 << 32)).to_bytes(4, "little")
        return data

    return altered(change)
