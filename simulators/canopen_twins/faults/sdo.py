"""Which object an SDO conversation is about, and how far it has come, as seen from the bus."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.wire import Onward
from canopen_twins.device.faults import Parameter
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError, unknown
from canopen_twins.faults.disturbance import (
    AIM,
    Effect,
    Filtering,
    Kind,
    Place,
    Side,
    Turn,
    altered,
    late,
    lost,
)
from canopen_twins.slave.object import Address
from canopen_twins.slave.sdo.server import REQUEST_LENGTH, SdoServer
from canopen_twins.slave.service import State

READ, WRITE = "read", "write"
ABORT = 0x80
INITIATES = frozenset({*range(0x20, 0x60), *range(0xA0, 0xC0, 4), *range(0xC0, 0xE0, 2)})
READS = frozenset({*range(0x40, 0x60), *range(0xA0, 0xC0)})
BLOCK_DOWNLOADS = range(0xC0, 0xE0)
END_OF_BLOCK_DOWNLOAD = 0xA1


class Conversation:
    """`segment` is 0 for the initiate and counts the requests of the transfer after it."""

    def __init__(self) -> None:
        self.address: Address | None = None
        self.access = ""
        self.segment = 0
        self._raw = False  # segments of a block download: their first byte is no command

    def ask(self, data: bytes) -> None:
        """The client has sent a request."""
        if data[0] == ABORT:
            self.address, self._raw = None, False
        elif data[0] in INITIATES and not self._raw:
            self.address = (data[1] | data[2] << 8, data[3])
            self.access = READ if data[0] in READS else WRITE
            self.segment = 0
            self._raw = data[0] in BLOCK_DOWNLOADS
        else:
            self.segment += 1

    def answer(self, data: bytes) -> None:
        """The server has answered."""
        if data[0] in (ABORT, END_OF_BLOCK_DOWNLOAD):
            self._raw = False


ANY = "any"
ACCESSES = (READ, WRITE, ANY)
ADDRESS = re.compile(r"0x([0-9A-Fa-f]{4})(?::([0-9A-Fa-f]{2}))?")
LARGEST_INDEX = 0xFFFF

OBJECT = {"object": Parameter("0x2014, 0x1018:02, its name in the EDS, or any", ANY, object)}
ACCESS = {"access": Parameter("read, write or any", ANY, str)}
SEGMENT = {"segment": Parameter("0: the initiate; n: the n-th request after it", 0, int, low=0)}


@dataclass(frozen=True)
class Aim:
    """What is None may be anything."""

    index: int | None
    subindex: int | None
    access: str | None
    segment: int

    @classmethod
    def at(cls, od: ObjectDictionary, object: int | str, access: str, segment: int) -> Aim:
        """What the parameters of a fault say.

        Raises:
            UserError: no such object, no such access.
        """
        if access not in ACCESSES:
            raise unknown("access", access, ACCESSES)
        return cls(*_address(od, object), None if access == ANY else access, segment)

    def hits(self, conversation: Conversation) -> bool:
        """Whether the request that came last is meant."""
        if conversation.address is None or conversation.segment != self.segment:
            return False
        found = (*conversation.address, conversation.access)
        wanted = (self.index, self.subindex, self.access)
        return all(one in (None, other) for one, other in zip(wanted, found, strict=True))


def _address(od: ObjectDictionary, object: int | str) -> tuple[int | None, int | None]:
    if object == ANY:
        return None, None
    if isinstance(object, int):
        if not 0 <= object <= LARGEST_INDEX:
            raise UserError(f"{object:#x} is no index; indices are 0x0000..0xffff")
        return object, None
    if match := ADDRESS.fullmatch(object):
        return int(match[1], 16), int(match[2], 16) if match[2] else None
    names = _names(od)
    if object not in names:
        raise unknown("object", object, names)
    return names[object]


def _names(od: ObjectDictionary) -> Mapping[str, tuple[int, int | None]]:
    names: dict[str, tuple[int, int | None]] = {}
    for name, item in od.names.items():
        names[name] = (item.index, None)
        if not isinstance(item, ODVariable):
            parts = item.subindices.values()
            names |= {f"{name}.{part.name}": (part.index, part.subindex) for part in parts}
    return names


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


GENERAL_ERROR = 0x0800_0000
SECONDS = Parameter("by how much, in s", 1.0, low=0)
INITIATE: Mapping[str, Parameter] = {**OBJECT, **ACCESS, **AIM}
ANYWHERE: Mapping[str, Parameter] = {**OBJECT, **ACCESS, **SEGMENT, **AIM}
LATER = {"segment": Parameter("n: the n-th request after the initiate", 1, int, low=1)}

SDO: Mapping[str, Kind] = {
    "sdo_abort": Kind(
        "An access is refused with an abort code; nothing is read or written.",
        "The abort code; the object as it was.",
        {
            "code": Parameter("abort code", GENERAL_ERROR, int, low=0, high=0xFFFF_FFFF),
            **ANYWHERE,
        },
        Refusal,
    ),
    "sdo_silence": Kind(
        "An access is carried out, but its answer never comes.",
        "A time-out; what was written is written.",
        ANYWHERE,
        lambda place, **aim: SdoFilter(place, lost, **aim),
    ),
    "sdo_late": Kind(
        "An answer comes late, if you like after the time-out of the master.",
        "A slow answer; after a time-out one that belongs to no request, or to the next.",
        {"seconds": SECONDS, **ANYWHERE},
        lambda place, seconds, **aim: SdoFilter(place, late(seconds), **aim),
    ),
    "sdo_wrong_index": Kind(
        "The answer to an initiate names the next index.",
        "An answer that is not its own: to be ignored or aborted, its value not to be used.",
        INITIATE,
        lambda place, **aim: SdoFilter(place, altered(other_index), **aim),
    ),
    "sdo_wrong_toggle": Kind(
        "The answer to a segment has the toggle bit of the one before.",
        "A protocol error: the master aborts with 0x05030000.",
        {**OBJECT, **ACCESS, **LATER, **AIM},
        lambda place, **aim: SdoFilter(place, altered(other_toggle), **aim),
    ),
    "sdo_wrong_size": Kind(
        "The answer to a read announces another size than its data have.",
        "A value of the wrong length, or a transfer that ends early: an error, no value.",
        {"by": Parameter("how many bytes too many", -1, int), **OBJECT, **AIM},
        lambda place, by, **aim: SdoFilter(place, other_size(by), access=READ, **aim),
    ),
    "sdo_stall": Kind(
        "A transfer stands still from a segment on.",
        "A time-out in the middle of a transfer: an abort, and a new start.",
        {**OBJECT, **ACCESS, **LATER, **AIM},
        lambda place, **aim: Stall(place, lost, **aim),
    ),
    "sdo_in_wrong_state": Kind(
        "SDO is answered while the node is stopped (CiA 301 forbids it).",
        "Answers it has no right to; a stopped node is not to be taken for a running one.",
        INITIATE,
        Unlocked,
    ),
}
