"""LSS slave: node id and bit timing by way of the identity, in every NMT state (CiA 305)."""

from collections.abc import Callable, Mapping, Sequence
from enum import IntEnum
from operator import eq, ge, le
from typing import NamedTuple, Protocol

from canopen_twins.bus import identifiers
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import UNCONFIGURED
from canopen_twins.slave.service import Listening, Service, State
from canopen_twins.slave.slave import Slave

LENGTH = 8
VENDOR, PRODUCT, REVISION, SERIAL = range(1, 5)  # sub-indices of the identity 0x1018

SELECTED, IDENTIFIED, NOT_CONFIGURED = 0x44, 0x4F, 0x50
BEGIN = 0x80  # of a fast scan, in the place of the lowest bit to compare
BITS = range(32)
ACCEPTED, REFUSED = 0, 1


class Stored(IntEnum):
    """How storing went, as it is answered."""

    DONE = 0
    NOT_SUPPORTED = 1
    FAILED = 2


class Configurable(Protocol):
    """What a device lets LSS change. Nothing of it acts before a reset or `activate_bit_timing`."""

    def configure_node_id(self, node_id: int) -> bool:
        """Keep a node id for the next reset, 255 for none; whether it is admissible."""

    def configure_bit_timing(self, table: int, index: int) -> bool:
        """Keep a bit rate by table selector and index; whether the device has it."""

    def activate_bit_timing(self) -> None:
        """Switch to the bit rate that is kept."""

    def store(self) -> Stored:
        """Make node id and bit rate outlive the power."""


class IdentityRequest(NamedTuple):
    """One request of a sequence that addresses a slave by its identity."""

    command: int
    subindex: int
    fits: Callable[[int, int], bool]


SELECT = (
    IdentityRequest(0x40, VENDOR, eq),
    IdentityRequest(0x41, PRODUCT, eq),
    IdentityRequest(0x42, REVISION, eq),
    IdentityRequest(0x43, SERIAL, eq),
)
IDENTIFY = (
    IdentityRequest(0x46, VENDOR, eq),
    IdentityRequest(0x47, PRODUCT, eq),
    IdentityRequest(0x48, REVISION, ge),
    IdentityRequest(0x49, REVISION, le),
    IdentityRequest(0x4A, SERIAL, ge),
    IdentityRequest(0x4B, SERIAL, le),
)


def identity(slave: Slave, subindex: int) -> int:
    """A number of the LSS address; 0 for one that 0x1018 leaves out."""
    return slave.number(0x1018, subindex) if slave.has(0x1018, subindex) else 0


class AddressSequence:
    """Follows a sequence of requests and knows when all of them have meant this slave."""

    def __init__(self, requests: Sequence[IdentityRequest], slave: Slave) -> None:
        self.commands = frozenset(request.command for request in requests)
        self._requests = requests
        self._slave = slave
        self._passed = 0

    def hear(self, data: bytes) -> bool:
        """Take the next request; whether the sequence is complete with it."""
        if data[0] == self._requests[0].command:
            self._passed = 0
        request = self._requests[self._passed]
        own = identity(self._slave, request.subindex)
        fits = data[0] == request.command and request.fits(own, int.from_bytes(data[1:5], "little"))
        self._passed = (self._passed + 1) % len(self._requests) if fits else 0
        return fits and not self._passed


class LssSlave(Service):
    """Waits until the master selects it; then it can be asked and configured.

    A node without a node id does nothing else, and begins its life when it has got one.
    """

    active_in = frozenset(State)

    def __init__(self, slave: Slave, device: Configurable) -> None:
        super().__init__(slave)
        self.configuring = False
        self._pending = slave.node_id  # as far as it has come by LSS
        self._scanned = 0  # the part of the identity that a fast scan is at
        self._device = device
        self._select = AddressSequence(SELECT, slave)
        self._identify = AddressSequence(IDENTIFY, slave)
        self._commands: Mapping[int, Callable[[bytes], bytes | None]] = {
            0x11: self._configure_node_id,
            0x13: self._configure_bit_timing,
            0x15: self._activate_bit_timing,
            0x17: self._store,
            0x5A: self._inquire(VENDOR),
            0x5B: self._inquire(PRODUCT),
            0x5C: self._inquire(REVISION),
            0x5D: self._inquire(SERIAL),
            0x5E: lambda _: bytes([self.slave.node_id]),
        }

    def listen(self) -> Listening:
        """The requests of the LSS master."""
        yield (identifiers.LSS_REQUEST, False), self.on_request

    def on_request(self, frame: Frame) -> None:
        """Answer where CiA 305 wants an answer; a slave that is not meant is silent."""
        data = frame.data
        if len(data) != LENGTH:
            return
        if data[0] == 0x04:
            self._switch(data[1])
        elif data[0] == 0x4C:
            if self._unconfigured:
                self._answer(NOT_CONFIGURED)
        elif data[0] == 0x51:
            if self._unconfigured and not self.configuring:
                self._scan(data)
        elif data[0] in self._identify.commands:
            if self._identify.hear(data):
                self._answer(IDENTIFIED)
        elif not self.configuring:
            if data[0] in self._select.commands and self._select.hear(data):
                self.configuring = True
                self._answer(SELECTED)
        elif command := self._commands.get(data[0]):
            answer = command(data)
            if answer is not None:
                self._answer(data[0], answer)

    @property
    def _unconfigured(self) -> bool:
        return self.slave.node_id == self._pending == UNCONFIGURED

    def _switch(self, mode: int) -> None:
        """To waiting or configuration; a node that has got its first id boots (CiA 305)."""
        self.configuring = mode == 1 if mode in {0, 1} else self.configuring
        if mode == 0 and self.slave.node_id == UNCONFIGURED and not self._unconfigured:
            self.slave.restart = True

    def _scan(self, data: bytes) -> None:
        """Fast scan: agree to bits of the identity, from `lowest` up, part after part."""
        number, (lowest, part, following) = int.from_bytes(data[1:5], "little"), data[5:8]
        if lowest == BEGIN:
            self._scanned = 0
        elif part == self._scanned and part < SERIAL and lowest in BITS:
            if (number ^ identity(self.slave, VENDOR + part)) >> lowest:
                return
            self._scanned = following
            self.configuring = lowest == 0 and following < part
        else:
            return
        self._answer(IDENTIFIED)

    def _answer(self, command: int, content: bytes = b"") -> None:
        data = (bytes([command]) + content).ljust(LENGTH, b"\0")
        self.slave.send(Frame(identifiers.LSS_ANSWER, data))

    def _configure_node_id(self, data: bytes) -> bytes:
        accepted = self._device.configure_node_id(data[1])
        if accepted:
            self._pending = data[1]
        return bytes([ACCEPTED if accepted else REFUSED])

    def _configure_bit_timing(self, data: bytes) -> bytes:
        accepted = self._device.configure_bit_timing(data[1], data[2])
        return bytes([ACCEPTED if accepted else REFUSED])

    def _store(self, data: bytes) -> bytes:
        return bytes([self._device.store()])

    def _inquire(self, subindex: int) -> Callable[[bytes], bytes]:
        return lambda _: identity(self.slave, subindex).to_bytes(4, "little")

    def _activate_bit_timing(self, data: bytes) -> None:
        """Off the bus for the delay, switch, off the bus for it again: then all have switched."""
        delay = int.from_bytes(data[1:3], "little") / 1000
        self.slave.shut = True
        self.slave.clock.after(delay, self._device.activate_bit_timing)
        self.slave.clock.after(2 * delay, self._reopen)

    def _reopen(self) -> None:
        self.slave.shut = False
