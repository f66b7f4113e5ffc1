"""Supply and presence of a node: it is off, it resets, or it is there twice."""

from dataclasses import fields

from simulators.mischief.disturbance import Disturbance, Place
from simulators.node import Node


class Supply(Disturbance):
    """The supply fails so many times for so long, with a pause in between."""

    def __init__(self, place: Place, seconds: float, pause: float, times: int) -> None:
        super().__init__(place.node)
        self._seconds = seconds
        self._pause = pause
        self._left = times
        self._off = False  # by us: a node that somebody else has switched off stays so

    @property
    def over(self) -> bool:
        """The supply is back for good."""
        return not self._left and not self._off

    def start(self) -> None:
        """It fails for the first time."""
        self._fail()

    def stop(self) -> None:
        """It is back."""
        super().stop()
        self._return()

    def _fail(self) -> None:
        self._left -= 1
        self._off = self.node.powered
        self.node.power_off()
        self.clock.after(self._seconds, self._recover)

    def _recover(self) -> None:
        self._return()
        if self._left:
            self.clock.after(self._pause, self._fail)

    def _return(self) -> None:
        if self._off:
            self._off = False
            self.node.power_on()


class ResetLoop(Disturbance):
    """All that is volatile is lost every so many seconds."""

    def __init__(self, place: Place, seconds: float, times: int) -> None:
        super().__init__(place.node)
        self._seconds = seconds
        self._times = times
        self._done = 0

    @property
    def over(self) -> bool:
        """There have been as many resets as there should be."""
        return 0 < self._times <= self._done

    def start(self) -> None:
        """The first one comes after a period."""
        self.clock.after(self._seconds, self._reset)

    def _reset(self) -> None:
        if self.node.powered:
            self.node.power_off()
            self.node.power_on()
        self._done += 1
        if not self.over:
            self.clock.after(self._seconds, self._reset)


class Duplicate(Disturbance):
    """Another device of the kind on the same segment; its frames carry the name of the first."""

    def __init__(self, place: Place) -> None:
        super().__init__(place.node)
        self._nodes = place.nodes
        device, wire = place.node.device, place.node.wire
        given = {
            entry.name: getattr(device.settings, entry.name) for entry in fields(device.settings)
        }
        twin = type(device)(**{**given, "node_id": place.node.node_id})
        self._twin = Node(twin, place.node.clock, wire.outbox, wire.name)

    def start(self) -> None:
        """It is plugged in."""
        self._nodes.append(self._twin)
        self._twin.power_on()

    def stop(self) -> None:
        """It is unplugged."""
        super().stop()
        self._twin.power_off()
        self._nodes.remove(self._twin)
