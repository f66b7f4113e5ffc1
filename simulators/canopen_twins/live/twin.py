"""A twin in real time on a python-can bus, in a thread of its own."""

from collections import deque
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from threading import Event, Thread
from types import TracebackType
from typing import Any

import can

from canopen_twins import devices
from canopen_twins.bench.twin import QUESTIONS, Twin, carry_out
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Record, Segment
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.report import SHOWN, scene
from canopen_twins.faults import connect
from canopen_twins.live.orders import Orders
from canopen_twins.live.serve import serve

PATIENCE = 10.0  # seconds for the thread to do what it is asked


class LiveTwin(Twin, AbstractContextManager["LiveTwin"]):
    """Everything the twin does happens in its thread between two frames, orders as well."""

    def __init__(
        self, device: devices.What, settings: Mapping[str, object], bus: Mapping[str, Any]
    ) -> None:
        name = devices.name_of(device)
        self.bus = dict(bus)
        """What to open to be on the same bus: `can.Bus(**twin.bus)`."""
        self._segment: Segment[Node] = Segment()
        self._node: Node = connect(self._segment, devices.create(device, **settings), name)
        self._segment.listeners.append(self._record)
        self._records: deque[Record] = deque(maxlen=SHOWN)
        self._orders = Orders()
        self._ready, self._stop = Event(), Event()
        self._bug: BaseException | None = None
        self._thread = Thread(target=self._run, name=f"twin {name}")

    def __enter__(self) -> "LiveTwin":
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

    def order(self, word: str, *arguments: Any) -> None:
        """By the thread of the twin; raises `RuntimeError` if that has stopped."""
        self._have_done(lambda: carry_out(self._segment, self._node, word, *arguments))

    def ask(self, word: str, *arguments: Any) -> Any:
        """By the thread of the twin, too, as the model is not to be seen half-way."""
        return self._have_done(lambda: QUESTIONS[word](self._node, *arguments))

    def _have_done(self, action: Callable[[], Any]) -> Any:
        if not self._thread.is_alive():
            raise RuntimeError(f"{self._thread.name} has stopped") from self._bug
        return self._orders.put(action).result(PATIENCE)

    def scene(self) -> str:
        """The last frames in words, how the device is, and why it answered as it did."""
        return scene(list(self._records), [self._node])

    def _run(self) -> None:
        try:
            self._node.power_on()
            serve(
                self._segment,
                lambda: can.Bus(**self.bus),
                self._stop.is_set,
                self._ready.set,
                self._orders,
            )
        except BaseException as bug:
            self._bug = bug
        finally:
            self._ready.set()

    def _record(self, frame: Frame, sender: str) -> None:
        self._records.append(Record(self._segment.clock.now, frame, sender))

    def _end(self) -> None:
        self._stop.set()
        self._thread.join()
        if self._bug is not None:
            raise self._bug
