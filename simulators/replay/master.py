"""The scenario's own end of the bus: sends as a master would, and waits for nobody."""

from simulators.objects import Address
from simulators.segment import Segment
from simulators.wire import Frame

NAME = "scenario"
EXPEDITED_ROOM = 4
ACCEPTED = 0
DOWNLOADED, ABORTED = 0x60, 0x80  # command specifiers of the server


class Master:
    """What it sends carries its name, so that it finds its way to a real bus."""

    def __init__(self, segment: Segment) -> None:
        self._segment = segment
        self._wire = segment.master(NAME)

    def send(self, frame: Frame) -> None:
        """Put a frame on the bus; the answers are out when this returns."""
        self._wire.put(frame)
        self._segment.deliver()

    def download(self, node_id: int, address: Address, data: bytes, sized: bool) -> int | None:
        """Write up to four bytes by SDO: 0 if accepted, the abort code, or None without answer.

        Without `sized` the request leaves open how many of its four bytes count.
        """
        index, subindex = address
        multiplexer = index.to_bytes(2, "little") + bytes([subindex])
        answers: list[bytes] = []

        def hear(frame: Frame, sender: str) -> None:
            if frame.can_id == 0x580 + node_id and frame.data[1:4] == multiplexer:
                answers.append(frame.data)

        head = 0x23 | EXPEDITED_ROOM - len(data) << 2 if sized else 0x22
        request = bytes([head]) + multiplexer + data.ljust(EXPEDITED_ROOM, b"\0")
        self._segment.listeners.append(hear)
        self.send(Frame(0x600 + node_id, request))
        self._segment.listeners.remove(hear)
        return _meaning(answers[0]) if answers else None


def _meaning(answer: bytes) -> int | None:
    codes = {DOWNLOADED: ACCEPTED, ABORTED: int.from_bytes(answer[4:8], "little")}
    return codes.get(answer[0])
