"""A twin on a python-can bus in a thread of its own: what a test in real time holds in its hand."""

from collections import deque
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from queue import Empty, SimpleQueue
from threading import Event, Thread
from types import TracebackType
from typing import Any

import can

from canopen_twins import devices
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Record, Segment
from canopen_twins.device.device import Device
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.report import SHOWN, scene
from canopen_twins.faults import connect
from canopen_twins.live.serve import serve

PATIENCE = 10.0  # seconds for the thread to do what it is asked


class Served(AbstractContextManager["Served"]):
    """Everything the twin does happens in its thread, also what a test asks it to do."""

    def __init__(self, device: str, settings: Mapping[str, object], bus: Mapping[str, Any]) -> None:
        self.bus = dict(bus)
        """What to open to be on the same bus: `can.Bus(**served.bus)`."""
        self._segment: Segment[Node] = Segment()
        self._node: Node = connect(self._segment, devices.create(device, **settings), device)
        self._segment.listeners.append(self._record)
        self._records: deque[Record] = deque(maxlen=SHOWN)
        self._orders: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._ready, self._stop = Event(), Event()
        self._bug: BaseException | None = None
        self._thread = Thread(target=self._run, name=f"twin {device}")

    @property
    def node_id(self) -> int:
        """The node id in force."""
        return self._node.node_id

    def __enter__(self) -> "Served":
        self._thread.start()
        if not self._ready.wait(PATIENCE) or self._bug is not None:
            self._end()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._end()

    def inject(self, name: str, **parameters: object) -> None:
        """Let something go wrong; `UserError` for an unknown fault or parameter."""
        self._act(lambda _: self._node.faults.inject(name, **parameters))

    def clear(self, name: str | None = None) -> None:
        """Take one fault away, or all of them."""
        self._act(lambda _: self._node.faults.clear(name))

    def set(self, **settings: object) -> None:
        """Change live settings of the device, such as its load."""
        self._act(lambda device: device.set(**settings))

    def power_off(self) -> None:
        """Switch the supply off."""
        self._order(self._node.power_off)

    def power_on(self) -> None:
        """Switch the supply on."""
        self._order(self._node.power_on)

    def report(self) -> str:
        """The last frames in words, how the device is, and why it answered as it did."""
        return scene(list(self._records), [self._node])

    def _act(self, action: Callable[[Device], None]) -> None:
        def act() -> None:
            with self._node.acting() as device:
                action(device)

        self._order(act)

    def _order(self, action: Callable[[], None]) -> None:
        """Have something done by the twin's thread, and wait for it."""
        done: SimpleQueue[BaseException | None] = SimpleQueue()

        def carry_out() -> None:
            try:
                action()
                self._segment.deliver()
            except Exception as refusal:
                done.put(refusal)
            else:
                done.put(None)

        if not self._thread.is_alive():
            raise RuntimeError(f"{self._thread.name} has stopped") from self._bug
        self._orders.put(carry_out)
        if (refusal := done.get(timeout=PATIENCE)) is not None:
            raise refusal

    def _run(self) -> None:
        try:
            self._node.power_on()
            serve(self._segment, lambda: can.Bus(**self.bus), self._stopped, self._ready.set)
        except BaseException as bug:
            self._bug = bug
        finally:
            self._ready.set()

    def _stopped(self) -> bool:
        """Asked by `serve` again and again: the moment for what others want done."""
        while True:
            try:
                self._orders.get_nowait()()
            except Empty:
                return self._stop.is_set()

    def _record(self, frame: Frame, sender: str) -> None:
        self._records.append(Record(self._segment.clock.now, frame, sender))

    def _end(self) -> None:
        self._stop.set()
        self._thread.join()
        if self._bug is not None:
            raise self._bug
