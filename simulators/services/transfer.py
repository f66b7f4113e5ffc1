"""Segmented SDO transfers: what is known of one between its initiate and its end."""

from simulators.entry import Entry
from simulators.objects import Abort, Rejected
from simulators.slave import Slave

SEGMENT_ROOM = 7
TOGGLE = 1 << 4
LAST = 1


class Transfer:
    """One open transfer; `segment` answers a request of the client or raises `Rejected`."""

    def __init__(self) -> None:
        self.done = False
        self._toggle = 0

    def segment(self, data: bytes) -> bytes:
        """Answer the next segment."""
        if data[0] & TOGGLE != self._toggle:
            raise Rejected("toggle bit did not alternate", Abort.TOGGLE)
        toggle, self._toggle = self._toggle, self._toggle ^ TOGGLE
        return self._exchange(data, toggle)

    def _exchange(self, data: bytes, toggle: int) -> bytes:
        raise NotImplementedError


class Upload(Transfer):
    """From the server to the client: the value as it was when the transfer began."""

    def __init__(self, value: bytes) -> None:
        super().__init__()
        self._left = value

    def _exchange(self, data: bytes, toggle: int) -> bytes:
        part, self._left = self._left[:SEGMENT_ROOM], self._left[SEGMENT_ROOM:]
        self.done = not self._left
        head = toggle | SEGMENT_ROOM - len(part) << 1 | (LAST if self.done else 0)
        return bytes([head]) + part.ljust(SEGMENT_ROOM, b"\0")


class Download(Transfer):
    """From the client to the server: nothing is written before the last segment is there."""

    def __init__(self, entry: Entry, slave: Slave, longest: int, announced: int | None) -> None:
        super().__init__()
        self._entry = entry
        self._slave = slave
        self._longest = longest
        self._announced = announced
        self._data = b""

    def _exchange(self, data: bytes, toggle: int) -> bytes:
        self._data += data[1 : 8 - (data[0] >> 1 & 7)]
        longest = self._longest if self._announced is None else self._announced
        if len(self._data) > longest:
            raise Rejected(f"more than {longest} bytes", self._slave.profile.too_long)
        if data[0] & LAST:
            self._finish()
        return bytes([0x20 | toggle]) + bytes(SEGMENT_ROOM)

    def _finish(self) -> None:
        if self._announced is not None and len(self._data) < self._announced:
            raise Rejected(f"fewer than {self._announced} bytes", self._slave.profile.too_short)
        self._slave.write(self._entry, self._data)
        self.done = True
