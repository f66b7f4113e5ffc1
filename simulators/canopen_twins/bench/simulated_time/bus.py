"""A python-can bus that is an end of the bench's bus."""

from collections import deque
from collections.abc import Mapping
from functools import partial
from typing import Any

import can
import canopen

from canopen_twins.bench.simulated_time.primitives import EPOCH, Condition, Queue
from canopen_twins.bench.simulated_time.scheduler import Scheduler, in_force
from canopen_twins.bus.clock import Clock
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.python_can import frame_of, message_of

BIT_RATE = 500_000
NAME = "master {}"  # of the buses that a master opens, one after the other
OVERHEAD, EXTENSION = 47, 20  # bits around the data, with a pause of three; 29-bit identifiers


class Reception:
    """Frames come in one after the other, each after its time on the wire.

    Twins answer at the moment of the request. If that took no time at all, a master that asks in a
    loop until a deadline would never reach it.
    """

    def __init__(self, clock: Clock, bit_rate: float) -> None:
        self._clock = clock
        self._bit_rate = bit_rate
        self._free = 0.0  # when the wire is free again, in seconds

    def delay(self, frame: Frame) -> float:
        """Seconds until a frame that is sent now is in, without stuff bits."""
        bits = OVERHEAD + EXTENSION * frame.extended + 8 * len(frame.data)
        self._free = max(self._free, self._clock.now) + bits / self._bit_rate
        return self._free - self._clock.now


class SimulatedBus(can.BusABC):
    """What an unmodified master gets when it opens a bus, whatever interface it asks for.

    Of what it asks for, `bitrate`, `can_filters` and `receive_own_messages` count.
    """

    def __init__(self, scheduler: Scheduler, name: str, config: Mapping[str, Any]) -> None:
        self.channel_info = f"{name} on the bench"
        self._scheduler = scheduler
        self._wire = scheduler.segment.master(name)
        self._reception = Reception(scheduler.clock, config.get("bitrate", BIT_RATE))
        self._hears_itself = config.get("receive_own_messages", False)
        self._received: deque[can.Message] = deque()
        channel: Any = config.get("channel")
        super().__init__(channel, config.get("can_filters"))
        scheduler.segment.listeners.append(self._hear)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """See `can.BusABC`."""
        if self._is_shutdown:
            raise can.CanOperationError("the bus has been shut down")
        if msg.is_fd or msg.is_error_frame:
            raise can.CanOperationError("a bench carries data frames and remote frames of CAN 2.0")
        self._scheduler.count("sends")
        self._wire.put(frame_of(msg))
        try:
            self._scheduler.segment.deliver()
        except Exception as bug:  # of a twin: python-can and canopen log it at best
            self._scheduler.failure = self._scheduler.failure or bug
            raise

    def shutdown(self) -> None:
        """See `can.BusABC`."""
        if not self._is_shutdown:
            self._scheduler.segment.listeners.remove(self._hear)
        super().shutdown()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self._scheduler.wait(lambda: self._received, timeout):
            return None, False
        return self._received.popleft(), False

    def _hear(self, frame: Frame, sender: str) -> None:
        if sender != self._wire.name or self._hears_itself:
            limited = self._scheduler.segment.limited  # then it has taken its time already
            delay = 0.0 if limited else self._reception.delay(frame)
            self._scheduler.clock.after(delay, partial(self._receive, frame))

    def _receive(self, frame: Frame) -> None:
        now = EPOCH + self._scheduler.clock.now
        self._received.append(message_of(frame, timestamp=now))
        self._scheduler.changed()


class Buses:
    """What stands in for `can.Bus`: every call opens another bus."""

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler
        self._opened: list[SimulatedBus] = []

    def open(self, channel: Any = None, *_: object, **config: Any) -> SimulatedBus:
        """See `can.Bus`."""
        name = NAME.format(len(self._opened) + 1)
        self._opened.append(SimulatedBus(self._scheduler, name, {"channel": channel, **config}))
        return self._opened[-1]

    def close(self) -> None:
        """Shut down every bus, and keep nothing of it.

        python-can keeps each notifier that nobody has stopped, and with it all the bench.
        """
        for bus in self._opened:
            bus.shutdown()
            for notifier in can.Notifier.find_instances(bus):
                # to stop it would call listeners of the master when its time is over
                can.Notifier._registry.unregister(bus, notifier)  # noqa: SLF001


class Notifier(can.Notifier):
    """python-can's own; its thread waits on the clock of the bench as every thread does."""

    def __init__(self, bus: Any, listeners: Any, *arguments: Any, **keywords: Any) -> None:
        for listener in listeners:
            if isinstance(network := getattr(listener, "network", None), canopen.Network):
                _check(network)
        super().__init__(bus, listeners, *arguments, **keywords)


def _check(network: canopen.Network) -> None:
    """What canopen waits with is made with its networks and nodes, not when it waits."""
    remotes = [node for node in network.values() if isinstance(node, canopen.RemoteNode)]
    waiting = [remote.nmt.state_update for remote in remotes]
    if isinstance(network.lss.responses, Queue) and all(isinstance(w, Condition) for w in waiting):
        return
    raise in_force().refusal(
        "this canopen.Network, or a node in it, was made before simulated time began and would"
        " wait in real time: make it inside"
    )
