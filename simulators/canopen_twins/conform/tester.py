"""The tester: it sends frames to one slave and waits for what comes, on whichever clock."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable

from canopen_twins.bus import identifiers, sdo
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.sdo import Address
from canopen_twins.conform.bus import Bus
from canopen_twins.scenario.sdo_client import ACCEPTED, Answer, Transfer, download, upload
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.nmt import STATE_BYTE
from canopen_twins.slave.object import entries_of
from canopen_twins.slave.service import State

START, STOP, ENTER_PRE_OPERATIONAL, RESET_NODE, RESET_COMMUNICATION = 0x01, 0x02, 0x80, 0x81, 0x82

PATIENCE = 1.0  # seconds for an answer
BOOT_TIME = 10.0  # seconds for a boot-up message
HEARTBEAT = 500  # milliseconds
SILENCE = 0.3  # seconds in which a frame would have come that must not come
ON_ITS_WAY = 0.02  # seconds that a frame takes at most to come over a bus and a busy machine
MOST_REQUESTS = 20_000  # of one transfer
KEPT = 12  # frames that are told of a topic that has failed


class Failed(Exception):  # noqa: N818 - it is a finding, nothing has gone wrong here
    """The slave has done something else than the standard wants, in words."""


class NotApplicable(Exception):  # noqa: N818 - nor here
    """There is nothing to test, and why; `index` is the object that says so, if one does."""

    def __init__(self, reason: str, index: int | None = None) -> None:
        super().__init__(reason)
        self.index = index


Provocation = Callable[[], AbstractContextManager[None]]
"""While it lasts something is wrong with the slave, which may be a reason for an EMCY."""


@dataclass
class Slave:
    """The slave that is tested."""

    name: str
    node_id: int
    dictionary: ObjectDictionary
    """What it should have, for its node id."""
    eds: str
    """Where that is from: a file of od/, or a path."""
    provocations: Sequence[Provocation] = ()
    """None: nobody is at hand who could let something go wrong."""


class Tester:
    """What topics are written in; `slave` is what they may know, the rest they have to ask."""

    def __init__(self, bus: Bus, slave: Slave) -> None:
        self.slave = slave
        self.frames: deque[Frame] = deque(maxlen=KEPT)
        """The last ones, of both sides."""
        self._bus = bus
        self._boot_time = BOOT_TIME

    @property
    def now(self) -> float:
        """Seconds of the clock."""
        return self._bus.now

    # Frames

    def send(self, can_id: int, data: bytes = b"", remote: bool = False) -> None:
        """Put a frame on the bus."""
        frame = Frame(can_id, data, remote)
        self.frames.append(frame)
        self._bus.send(frame)

    def listen(self, seconds: float) -> Iterator[Frame]:
        """What others send in so many seconds, as it comes."""
        end = self.now + seconds
        while (frame := self._bus.receive(max(end - self.now, 0.0))) is not None:
            self.frames.append(frame)
            yield frame

    def hear(self, can_id: int, seconds: float = PATIENCE, length: int | None = None) -> bytes:
        """The data of the next data frame with an identifier.

        Raises:
            Failed: none has come in time, or it has not as many bytes as it should have.
        """
        for frame in self.listen(seconds):
            if frame.can_id == can_id and not frame.remote and not frame.extended:
                if length is not None and len(frame.data) != length:
                    raise Failed(f"{frame} has {len(frame.data)} bytes instead of {length}")
                return frame.data
        raise Failed(f"no {can_id:03X} in {seconds:g} s")

    def count(self, can_id: int, seconds: float) -> int:
        """How many data frames with an identifier come in so many seconds."""
        return sum(frame.can_id == can_id and not frame.remote for frame in self.listen(seconds))

    def times(self, can_id: int, seconds: float) -> list[float]:
        """When they come."""
        return [self.now for frame in self.listen(seconds) if frame.can_id == can_id]

    def expect_silence(self, can_id: int, why: str, seconds: float = SILENCE) -> None:
        """Nothing comes with an identifier, because of a reason that is told otherwise."""
        for frame in self.listen(seconds):
            if frame.can_id == can_id and not frame.remote:
                raise Failed(f"{frame} {why}")

    def forget(self) -> None:
        """What has come and was not waited for is of no interest, nor what is on its way."""
        for _ in self.listen(ON_ITS_WAY):
            pass

    # NMT

    def nmt(self, command: int) -> None:
        """Command this node."""
        self.send(identifiers.NMT, bytes([command, self.slave.node_id]))

    def reset(self, command: int = RESET_NODE) -> None:
        """Reset, and wait for the boot-up message.

        Raises:
            Failed: there is none.
        """
        self.nmt(command)
        if self.hear(self.error_control, self._boot_time) != b"\0":
            raise Failed(f"{self.frames[-1]} instead of a boot-up message")

    def prepare(self) -> None:
        """As it is after a reset; who has never told that it boots is not waited for again."""
        self.forget()
        try:
            self.reset()
        except Failed:
            self._boot_time = SILENCE
            self.nmt(ENTER_PRE_OPERATIONAL)
        self.forget()
        self.frames.clear()

    def watch(self) -> float:
        """Let the heartbeat tell the state; its period in seconds, 0 if there is none."""
        entry = self.entry(0x1017)
        if entry is None:
            return 0.0
        if entry.writable:
            self.write((0x1017, 0), HEARTBEAT)
        return self.number(0x1017) / 1000

    def expect_state(self, state: State, period: float) -> None:
        """The slave tells a state with a heartbeat of such a period, or acts like it without.

        Raises:
            Failed: it tells another one.
        """
        self.forget()
        if period:
            told = self.hear(self.error_control, 2 * period + SILENCE)
            if told != bytes([STATE_BYTE[state]]):
                raise Failed(f"its heartbeat tells {told.hex()} while it should be {state.lower()}")
        elif self.is_answering() is (state is State.STOPPED):
            raise Failed(f"SDO tells that it is not {state.lower()}")

    # Identifiers of the predefined connection set, which no slave can change

    @property
    def error_control(self) -> int:
        """Of heartbeat, boot-up and node guarding."""
        return identifiers.heartbeat(self.slave.node_id)

    @property
    def requests(self) -> int:
        """Of SDO requests."""
        return identifiers.sdo_request(self.slave.node_id)

    @property
    def answers(self) -> int:
        """Of SDO answers."""
        return identifiers.sdo_answer(self.slave.node_id)

    # SDO

    def ask(self, data: bytes) -> bytes:
        """The answer to one SDO request.

        Raises:
            Failed: there is none.
        """
        self.send(self.requests, data)
        try:
            return self.hear(self.answers, length=sdo.LENGTH)
        except Failed as failure:
            raise Failed(f"no answer to {Frame(self.requests, data)}: {failure}") from None

    def is_answering(self) -> bool:
        """Whether the device type can be read now."""
        self.forget()
        self.send(self.requests, sdo.message(sdo.Ccs.UPLOAD, sdo.multiplexer((0x1000, 0))))
        return any(frame.can_id == self.answers for frame in self.listen(SILENCE))

    def transfer(self, transfer: Transfer) -> Answer:
        """A whole SDO transfer; the client aborts what goes wrong on its side."""
        request = next(transfer)
        named = request[1:4]
        try:
            for _ in range(MOST_REQUESTS):
                request = transfer.send(self.ask(request))
        except StopIteration as end:
            result: Answer = end.value
        else:
            raise Failed(f"a transfer has no end after {MOST_REQUESTS} requests")
        if result.by_client:
            self.send(self.requests, sdo.abort(named, result.code or ACCEPTED))
            raise Failed(f"{self.frames[-2]} is no answer to it")
        return result

    def read(self, address: Address) -> bytes:
        """The value of an entry.

        Raises:
            Failed: it cannot be read.
        """
        answer = self.transfer(upload(address))
        if answer.code != ACCEPTED:
            raise Failed(f"{address_text(address)} cannot be read: {answer.code:08X}h")
        return answer.data

    def number(self, index: int, subindex: int = 0) -> int:
        """The same as a number without a sign."""
        return int.from_bytes(self.read((index, subindex)), "little")

    def write(self, address: Address, value: int | bytes) -> None:
        """Let an entry have a value; a number gets the size that the dictionary says.

        Raises:
            Failed: it is refused.
        """
        if code := self.try_write(address, value):
            raise Failed(f"{address_text(address)} := {_shown(value)} is refused: {code:08X}h")

    def try_write(self, address: Address, value: int | bytes) -> int:
        """The abort code with which a value is refused, 0 if it is taken."""
        if isinstance(value, int):
            size = self.size(address)
            value = (value & (1 << 8 * size) - 1).to_bytes(size, "little")
        answer = self.transfer(download(address, value))
        assert answer.code is not None
        return answer.code

    def expect_refusal(self, address: Address, value: int | bytes, *codes: int) -> None:
        """Writing a value is refused with one of some abort codes."""
        self.expect_code(
            self.try_write(address, value), f"{address_text(address)} := {_shown(value)}", *codes
        )

    def expect_abort(self, answer: bytes, what: str, *codes: int) -> None:
        """An answer is an abort with one of some codes."""
        self.expect_code(sdo.abort_code(answer) if sdo.is_abort(answer) else 0, what, *codes)

    def expect_code(self, code: int, what: str, *codes: int) -> None:
        """An abort code is one of some.

        Raises:
            Failed: it is another, or 0, which stands for a request that was carried out.
        """
        if code not in codes:
            wanted = " or ".join(f"{each:08X}h" for each in codes)
            told = f"refused with {code:08X}h" if code else "carried out"
            raise Failed(f"{what} is {told} instead of {wanted}")

    # The dictionary that the slave should have

    def entry(self, index: int, subindex: int = 0) -> ODVariable | None:
        """An entry of it, none if there is none."""
        if index not in self.slave.dictionary.indices:
            return None
        return entries_of(self.slave.dictionary.indices[index]).get(subindex)

    def need(self, index: int, subindex: int = 0) -> ODVariable:
        """An entry without which there is nothing to test.

        Raises:
            NotApplicable: the dictionary has none.
        """
        entry = self.entry(index, subindex)
        if entry is None:
            raise NotApplicable(f"there is no {address_text((index, subindex))}", index)
        return entry

    def need_writable(self, index: int, subindex: int = 0) -> ODVariable:
        """The same for one that a master may write."""
        entry = self.need(index, subindex)
        if not entry.writable:
            text = f"{address_text((index, subindex))} cannot be written"
            raise NotApplicable(text, index)
        return entry

    def entries(self) -> Iterator[ODVariable]:
        """All of them, in their order."""
        for index in sorted(self.slave.dictionary.indices):
            yield from entries_of(self.slave.dictionary.indices[index]).values()

    def size(self, address: Address) -> int:
        """The bytes of a number by its type in the dictionary, 4 for what is none."""
        entry = self.entry(*address)
        codec = None if entry is None else entry.STRUCT_TYPES.get(entry.data_type or 0)
        return 4 if codec is None else int(codec.size)


def _shown(value: int | bytes) -> str:
    return f"{value:X}h" if isinstance(value, int) else value.hex()
