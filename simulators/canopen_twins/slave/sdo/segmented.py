"""Segmented SDO transfers (CiA 301, 7.2.4.3.3-8): one between its initiate and its end."""

from collections.abc import Sequence

from canopen_twins.slave.object import Abort, Entry, Rejected
from canopen_twins.slave.slave import Slave

SEGMENT_ROOM = 7
TOGGLE = 1 << 4
LAST = 1


class Transfer:
    """One open transfer; it ends when it is `done` or with the first `Rejected`."""

    done = False

    def opening(self, multiplexer: bytes) -> bytes:
        """The answer to the initiate."""
        raise NotImplementedError

    def continues(self, command: int) -> bool:
        """Whether a request with this command byte belongs to the transfer."""
        raise NotImplementedError

    def answer(self, data: bytes) -> Sequence[bytes]:
        """What to say to such a request.

        Raises:
            Rejected: the transfer is over.
        """
        raise NotImplementedError


class Target:
    """The entry that a download writes, and how many bytes it may bring."""

    def __init__(self, slave: Slave, entry: Entry, announced: int | None) -> None:
        """Raises `Rejected` if more is announced than there is room for."""
        self._slave = slave
        self._entry = entry
        self._announced = announced
        self._longest = slave.profile.longest_transfer if entry.size is None else entry.size
        if announced is not None:
            self.check(announced)
            self._longest = announced

    def check(self, length: int) -> None:
        """Raises `Rejected` if so many bytes are too many."""
        if length > self._longest:
            reason = f"{length} bytes are more than {self._longest}"
            raise Rejected(reason, self._slave.profile.too_long)

    def write(self, data: bytes) -> None:
        """Write all there is.

        Raises:
            Rejected: not as many bytes as announced, or refused by the entry.
        """
        self.check(len(data))
        if self._announced is not None and len(data) < self._announced:
            reason = f"{len(data)} bytes are fewer than {self._announced}"
            raise Rejected(reason, self._slave.profile.too_short)
        self._slave.write(self._entry, data)


class Segmented(Transfer):
    """Segments with a toggle bit, each answered by one."""

    command: int
    """The command specifier of its requests."""

    def __init__(self) -> None:
        self._toggle = 0

    def continues(self, command: int) -> bool:
        """Whether this is the command specifier; a wrong toggle bit belongs to it, too."""
        return command >> 5 == self.command

    def answer(self, data: bytes) -> Sequence[bytes]:
        """Answer the next segment."""
        if data[0] & TOGGLE != self._toggle:
            raise Rejected("toggle bit did not alternate", Abort.TOGGLE)
        toggle, self._toggle = self._toggle, self._toggle ^ TOGGLE
        return [self._exchange(data, toggle)]

    def _exchange(self, data: bytes, toggle: int) -> bytes:
        raise NotImplementedError


class Upload(Segmented):
    """From the server to the client: the value as it was when the transfer began."""

    command = 3

    def __init__(self, value: bytes) -> None:
        super().__init__()
        self._left = value

    def opening(self, multiplexer: bytes) -> bytes:
        """The size of the value."""
        return b"\x41" + multiplexer + len(self._left).to_bytes(4, "little")

    def _exchange(self, data: bytes, toggle: int) -> bytes:
        part, self._left = self._left[:SEGMENT_ROOM], self._left[SEGMENT_ROOM:]
        self.done = not self._left
        head = toggle | SEGMENT_ROOM - len(part) << 1 | (LAST if self.done else 0)
        return bytes([head]) + part.ljust(SEGMENT_ROOM, b"\0")


class Download(Segmented):
    """From the client to the server: nothing is written before the last segment is there."""

    command = 0

    def __init__(self, target: Target) -> None:
        super().__init__()
        self._target = target
        self._data = b""

    def opening(self, multiplexer: bytes) -> bytes:
        """Go ahead."""
        return b"\x60" + multiplexer + bytes(4)

    def _exchange(self, data: bytes, toggle: int) -> bytes:
        self._data += data[1 : 8 - (data[0] >> 1 & 7)]
        self._target.check(len(self._data))
        if data[0] & LAST:
            self._target.write(self._data)
            self.done = True
        return bytes([0x20 | toggle]) + bytes(SEGMENT_ROOM)
