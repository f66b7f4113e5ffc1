"""A python-can bus on a hub: unlike the `socketcand` interface it tells when the hub is gone."""

import select
import socket
from collections import deque
from collections.abc import Iterable

import can

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.hub.protocol import (
    UNKNOWN,
    HubAddress,
    Refused,
    Stream,
    element,
    owning,
    read_delivered,
    sent,
)
from canopen_twins.bus.python_can import frame_of, message_of

PATIENCE = 2.0  # seconds for the hub to answer when it is joined
SEND_PATIENCE = 0.5  # seconds for it to take a frame: a twin's time waits, and makes up for these
CHUNK = 1 << 16  # bytes


def is_hub(address: HubAddress) -> bool:
    """Whether somebody is there who greets as a hub does, or says why not."""
    try:
        with socket.create_connection(address, PATIENCE) as connection:
            return connection.recv(1) == element("hi")[:1]
    except OSError:
        return False


class HubBus(can.BusABC):
    """One client of a hub, or of a socketcand; remote frames come and go as such."""

    def __init__(self, address: HubAddress, channel: str, node_ids: Iterable[int] = ()) -> None:
        """Join a bus by its name, with node ids that are ours alone; a socketcand knows none.

        Raises:
            OSError: there is nobody, or nobody who answers in time.
            CanOperationError: it is refused, as where another one has such a node id.
        """
        self.channel_info = f"{channel} at {address}"
        self._stream = Stream()
        self._inbox: deque[str] = deque()
        self._socket = socket.create_connection(address, PATIENCE)
        try:
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._expect("hi")
            self._ask(f"open {channel}")
            if owned := owning(node_ids):
                self._ask(owned, or_else=UNKNOWN)
            self._ask("rawmode")
            self._socket.sendall(element("echo"))  # to hear at once: a hub waits for python-can
        except BaseException:
            self._socket.close()
            raise
        self._socket.settimeout(SEND_PATIENCE)
        super().__init__(channel)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame of classic CAN."""
        self._socket.sendall(sent(frame_of(msg)))

    def fileno(self) -> int:
        """For `select`, as python-can's notifier does."""
        return self._socket.fileno()

    def shutdown(self) -> None:
        """Leave."""
        super().shutdown()
        self._socket.close()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self._inbox and select.select([self._socket], [], [], timeout)[0]:
            self._fill()
        while self._inbox:
            if (frame := self._read(self._inbox.popleft())) is not None:
                return message_of(frame), False
        return None, False

    def _read(self, text: str) -> Frame | None:
        if text.startswith("error"):
            raise can.CanOperationError(f"the hub says: {text}")
        try:
            return read_delivered(text)
        except Refused as refusal:
            raise can.CanOperationError(str(refusal)) from refusal

    def _fill(self) -> None:
        if not (data := self._socket.recv(CHUNK)):
            raise can.CanOperationError("the hub is gone")
        try:
            self._inbox += self._stream.feed(data)
        except Refused as refusal:
            raise can.CanOperationError(f"there is no hub: {refusal}") from refusal

    def _ask(self, command: str, or_else: str | None = None) -> None:
        self._socket.sendall(element(command))
        self._expect("ok", or_else)

    def _expect(self, answer: str, or_else: str | None = None) -> None:
        while not self._inbox:
            self._fill()
        text = self._inbox.popleft()
        if text != answer and (or_else is None or not text.startswith(or_else)):
            raise can.CanOperationError(f"the hub says: {text}")
