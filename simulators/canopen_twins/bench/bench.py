"""A test bench: twins and a canopen master in one process, in simulated time, without a thread."""

from collections.abc import Mapping, Sequence
from typing import Any

import canopen

from canopen_twins import devices
from canopen_twins.bench.twin import Twin
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Record, Segment
from canopen_twins.bus.wire import PeriodicFrame
from canopen_twins.device.device import Device
from canopen_twins.device.node import Node


class Bench:
    """One or several twins with power on. Times are in seconds of the bench's own clock.

    `Bench("topcon", node_id=5, load="resistor 4")` has one twin and does what that twin does.
    `Bench.of({"left": ("topcon", 5), "right": ("topcon", 6)})` has several: `bench["left"].sdo`.

    Raises:
        UserError: an unknown device or setting, or two nodes with one id.
    """

    def __init__(self, device: str, **settings: object) -> None:
        self._connect({device: devices.create(device, **settings)})
        self._power_on()

    @classmethod
    def of(cls, nodes: Mapping[str, tuple[str, int] | Device]) -> "Bench":
        """Several nodes on one bus and one clock: for each name a device and its node id."""
        bench = cls.__new__(cls)
        bench._connect({name: _device(what) for name, what in nodes.items()})  # noqa: SLF001
        bench._power_on()  # noqa: SLF001
        return bench

    def _connect(self, parts: Mapping[str, Device]) -> None:
        self.segment: Segment[Node] = Segment()
        self.clock = self.segment.clock
        self.trace: list[Record] = []
        self.master: canopen.Network = Master(self.segment)
        self.twins = {
            name: Twin(name, device, self.segment, self.master) for name, device in parts.items()
        }
        self.segment.listeners.insert(0, self._record)

    def _power_on(self) -> None:
        for twin in self.twins.values():
            twin.power_on()

    def send(self, text: str) -> list[str]:
        """Put one frame on the bus; what the twins send before time moves.

        Raises:
            UserError: the text is no frame in the notation of cansend.
        """
        return self.put(Frame.parse(text))

    def put(self, frame: Frame) -> list[str]:
        """The same for a frame that is one already."""
        start = len(self.trace)
        self.segment.send(frame)
        return self._sent(start)

    def run(self, seconds: float) -> list[str]:
        """Let simulated time pass; what the twins send meanwhile."""
        start = len(self.trace)
        self.segment.advance(seconds)
        return self._sent(start)

    @property
    def sent(self) -> list[str]:
        """Everything the twins have sent so far."""
        return self._sent(0)

    def _record(self, frame: Frame, sender: str) -> None:
        self.trace.append(Record(self.clock.now, frame, sender))

    def _sent(self, start: int) -> list[str]:
        records: Sequence[Record] = self.trace[start:]
        return [str(record.frame) for record in records if record.sender in self.twins]

    def __getitem__(self, name: str) -> Twin:
        return self.twins[name]

    @property
    def twin(self) -> Twin:
        """The only twin of the bench.

        Raises:
            LookupError: there are several; take them by name.
        """
        if len(self.twins) != 1:
            raise LookupError(
                f"several twins: say which, such as bench[{next(iter(self.twins))!r}]"
            )
        return next(iter(self.twins.values()))

    @property
    def device(self) -> Any:
        """See `Twin.device`."""
        return self.twin.device

    @property
    def sdo(self) -> Any:
        """See `Twin.sdo`."""
        return self.twin.sdo

    def inject(self, name: str, **parameters: Any) -> None:
        """See `Twin.inject`."""
        self.twin.inject(name, **parameters)

    def clear(self, name: str | None = None) -> None:
        """See `Twin.clear`."""
        self.twin.clear(name)

    def set(self, **settings: object) -> None:
        """See `Twin.set`."""
        self.twin.set(**settings)

    def power_off(self) -> None:
        """See `Twin.power_off`."""
        self.twin.power_off()

    def power_on(self, **settings: object) -> None:
        """See `Twin.power_on`."""
        self.twin.power_on(**settings)


def _device(what: tuple[str, int] | Device) -> Device:
    if isinstance(what, Device):
        return what
    name, node_id = what
    return devices.create(name, node_id=node_id)


class Master(canopen.Network):
    """The master's end of a segment: what it sends, the twins have answered when this returns."""

    def __init__(self, segment: Segment[Node]) -> None:
        super().__init__()
        self._segment = segment
        segment.listeners.append(self._hear)

    def send_message(self, can_id: int, data: Sequence[int], remote: bool = False) -> None:
        """What canopen calls to send."""
        self._segment.send(Frame(can_id, bytes(data), remote, can_id > 0x7FF))

    def send_periodic(
        self, can_id: int, data: Sequence[int], period: float, remote: bool = False
    ) -> Any:
        """What canopen calls for SYNC and cyclic PDOs, every `period` seconds."""
        frame = Frame(can_id, bytes(data), remote, can_id > 0x7FF)
        return PeriodicFrame(self._segment.clock, period, frame, self._segment.send)

    def _hear(self, frame: Frame, sender: str) -> None:
        """What the twins send, as far as canopen knows it: no remote frames."""
        if sender and not frame.remote:
            self.notify(frame.can_id, bytearray(frame.data), self._segment.clock.now)
