"""Protocol level, SDO: accesses to objects are refused, not answered, or answered wrongly."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from canopen import ObjectDictionary

from canopen_twins.bus import identifiers, sdo
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.sdo import Ccs, Scs
from canopen_twins.bus.wire import Onward
from canopen_twins.device.faults import Parameter
from canopen_twins.errors import UserError, unknown
from canopen_twins.faults.disturbance import (
    AIM,
    Effect,
    FaultType,
    Filtering,
    Place,
    Side,
    altered,
    anything,
    late,
    lost,
)
from canopen_twins.slave.dictionary import Names, entries, parse_address
from canopen_twins.slave.object import Address
from canopen_twins.slave.sdo_server import SdoServer
from canopen_twins.slave.service import State

ANY = "any"
ACCESSES = (sdo.READ, sdo.WRITE, ANY)
LARGEST_INDEX = 0xFFFF

OBJECT = {"object": Parameter("0x2014, 0x1018:02, its name in the EDS, or any", ANY, object)}
ACCESS = {"access": Parameter("read, write or any", ANY, str)}
SEGMENT = {"segment": Parameter("0: the initiate; n: the n-th request after it", 0, int, low=0)}


Meant = Callable[[sdo.Conversation], bool]
"""Whether the request that came last is one of those that are aimed at."""


def meant(od: ObjectDictionary, object: int | str, access: str, segment: int) -> Meant:
    """What the parameters of a fault say.

    Raises:
        UserError: no such object, no such access.
    """
    if access not in ACCESSES:
        raise unknown("access", access, ACCESSES)
    index, subindex = _address(od, object)

    def fits(conversation: sdo.Conversation) -> bool:
        if conversation.address is None or conversation.segment != segment:
            return False
        its_index, its_subindex = conversation.address
        return (
            index in (None, its_index)
            and subindex in (None, its_subindex)
            and access in (ANY, conversation.access)
        )

    return fits


def _address(od: ObjectDictionary, object: int | str) -> tuple[int | None, int | None]:
    if object == ANY:
        return None, None
    if isinstance(object, int):
        if not 0 <= object <= LARGEST_INDEX:
            raise UserError(f"{object:#x} is no index; indices are 0x0000..0xffff")
        return object, None
    if (address := parse_address(object)) is not None:
        return address
    names: Names[tuple[int, int | None]] = Names(_named(od))
    if object not in names:
        raise unknown("object", object, names)
    return names[object]


def _named(od: ObjectDictionary) -> Iterator[tuple[str, Address, tuple[int, int | None]]]:
    for name, entry in entries(od):
        yield name, (entry.index, entry.subindex), (entry.index, entry.subindex)
    for index, whole in od.indices.items():
        yield whole.name, (index, 0), (index, None)


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
        **aim: Any,
    ) -> None:
        super().__init__(place, anything, effect, **aim)
        self._meant = meant(place.node.dictionary, object, access, segment)
        self._conversation = sdo.Conversation()
        self._struck = False

    def __call__(self, frame: Frame, onward: Onward) -> None:
        """Requests come in and answers go out through here."""
        if not self._running:
            onward(frame)
        elif sdo.is_answer(frame, self.node.node_id):
            self._conversation.answer(frame.data)
            if self._struck:
                self.strike(frame, onward)
            else:
                onward(frame)
        elif sdo.is_request(frame, self.node.node_id) and self.node.state in self.states:
            self._conversation.ask(frame.data)
            self._struck = self._hits()
            if self._struck:
                self.note(frame)
                self.on_request(frame, onward)
            else:
                onward(frame)
        else:
            onward(frame)

    def _hits(self) -> bool:
        return self._meant(self._conversation) and self._aim.strikes()

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
        self._code = code

    def on_request(self, frame: Frame, onward: Onward) -> None:
        """The server hears instead that the client has given up what was open."""
        address, slave = self._conversation.address, self.node.slave
        given_up = sdo.message(Ccs.ABORT)
        onward(frame._replace(data=given_up))
        self._struck = False
        self._conversation.ask(given_up)
        if address is not None and slave is not None:
            answer = sdo.abort(sdo.multiplexer(address), self._code)
            slave.send(Frame(identifiers.sdo_answer(slave.node_id), answer))


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


def other_index(data: bytes) -> bytes:
    """The answer, about the object at the next index."""
    index, subindex = sdo.address(data)
    return data[:1] + sdo.multiplexer((index + 1 & 0xFFFF, subindex)) + data[4:]


def other_toggle(data: bytes) -> bytes:
    """The answer to a segment, with the toggle bit the other way round."""
    return data if sdo.is_abort(data) else bytes([data[0] ^ sdo.TOGGLE]) + data[1:]


def other_size(by: int) -> Effect:
    """The answer to a read, with another size than its data have."""

    def change(data: bytes) -> bytes:
        told = sdo.size(data)
        if sdo.specifier(data) != Scs.UPLOAD or told is None:
            return data
        if sdo.is_expedited(data):  # 1..4 bytes, round the corner
            return sdo.with_size(data, (told - 1 + by) % sdo.EXPEDITED_ROOM + 1)
        return sdo.with_size(data, (told + by) % (1 << 32))

    return altered(change)


GENERAL_ERROR = 0x0800_0000
SECONDS = Parameter("by how much, in s", 1.0, low=0, delays_answers=True)
INITIATE: Mapping[str, Parameter] = {**OBJECT, **ACCESS, **AIM}
ANYWHERE: Mapping[str, Parameter] = {**OBJECT, **ACCESS, **SEGMENT, **AIM}
LATER = {"segment": Parameter("n: the n-th request after the initiate", 1, int, low=1)}

SDO: Mapping[str, FaultType] = {
    "sdo_abort": FaultType(
        "An access is refused with an abort code; nothing is read or written.",
        "The abort code; the object as it was.",
        {
            "code": Parameter("abort code", GENERAL_ERROR, int, low=0, high=0xFFFF_FFFF),
            **ANYWHERE,
        },
        Refusal,
    ),
    "sdo_silence": FaultType(
        "An access is carried out, but its answer never comes.",
        "A time-out; what was written is written.",
        ANYWHERE,
        lambda place, **aim: SdoFilter(place, lost, **aim),
    ),
    "sdo_late": FaultType(
        "An answer comes late, if you like after the time-out of the master.",
        "A slow answer; after a time-out one that belongs to no request, or to the next.",
        {"seconds": SECONDS, **ANYWHERE},
        lambda place, seconds, **aim: SdoFilter(place, late(seconds), **aim),
    ),
    "sdo_wrong_index": FaultType(
        "The answer to an initiate names the next index.",
        "An answer that is not its own: to be ignored or aborted, its value not to be used.",
        INITIATE,
        lambda place, **aim: SdoFilter(place, altered(other_index), **aim),
    ),
    "sdo_wrong_toggle": FaultType(
        "The answer to a segment has the toggle bit of the one before.",
        "A protocol error: the master aborts with 0x05030000.",
        {**OBJECT, **ACCESS, **LATER, **AIM},
        lambda place, **aim: SdoFilter(place, altered(other_toggle), **aim),
    ),
    "sdo_wrong_size": FaultType(
        "The answer to a read announces another size than its data have.",
        "A value of the wrong length, or a transfer that ends early: an error, no value.",
        {
            "by": Parameter("how many bytes too many", -1, int, low=-0xFFFF, high=0xFFFF),
            **OBJECT,
            **AIM,
        },
        lambda place, by, **aim: SdoFilter(place, other_size(by), access=sdo.READ, **aim),
    ),
    "sdo_stall": FaultType(
        "A transfer stands still from a segment on.",
        "A time-out in the middle of a transfer: an abort, and a new start.",
        {**OBJECT, **ACCESS, **LATER, **AIM},
        lambda place, **aim: Stall(place, lost, **aim),
    ),
    "sdo_in_wrong_state": FaultType(
        "SDO is answered while the node is stopped (CiA 301 forbids it).",
        "Answers it has no right to; a stopped node is not to be taken for a running one.",
        INITIATE,
        Unlocked,
    ),
}
