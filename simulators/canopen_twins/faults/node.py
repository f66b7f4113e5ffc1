"""Node level: it says it is another, loses its supply, resets itself, or is there twice."""

from collections.abc import Mapping
from dataclasses import fields

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.wire import Onward
from canopen_twins.device.faults import Parameter
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.faults.disturbance import (
    Disturbance,
    FaultType,
    Place,
)
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.object import Address, Entry, Object
from canopen_twins.slave.slave import Slave


class Counterfeit(Disturbance):
    """Puts another entry in the place of the true one, also in the slave that a reset makes.

    Raises:
        UserError: the device has no such object.
    """

    def __init__(self, place: Place, address: Address, value: int | str) -> None:
        super().__init__(place)
        if place.node.dictionary.get_variable(*address) is None:
            raise UserError(f"the device has no object {address_text(address)}")
        self._address = address
        self._value = value
        self._slave: Slave | None = None
        self._true: Entry | None = None

    def start(self) -> None:
        """In the slave that is there now; every frame looks whether it is a new one."""
        self._put()
        self.node.wire.filter_incoming([*self.node.wire.incoming, self._look])

    def stop(self) -> None:
        """Put the true entry back."""
        super().stop()
        wire = self.node.wire
        wire.filter_incoming([each for each in wire.incoming if each != self._look])
        index, subindex = self._address
        if self._slave is not None and self._true is not None:
            self._slave.entries[index][subindex] = self._true

    def _look(self, frame: Frame, onward: Onward) -> None:
        self._put()
        onward(frame)

    def _put(self) -> None:
        slave = self.node.slave
        if slave is None or slave is self._slave:
            return
        self._slave = slave
        index, subindex = self._address
        self._true = slave.entry(index, subindex)
        false = Entry(self._true.variable, {})
        false.bind(Object(read=lambda: false.pack(self._value)))
        slave.entries[index][subindex] = false


class Supply(Disturbance):
    """The supply fails so many times for so long, with a pause in between."""

    def __init__(self, place: Place, seconds: float, pause: float, times: int) -> None:
        super().__init__(place)
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
        super().__init__(place)
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
        super().__init__(place)
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


PERIOD = Parameter("from one to the next, in s", 1.0, low=1e-3)

NODE: Mapping[str, FaultType] = {
    "reset_loop": FaultType(
        "The watchdog resets the node again and again.",
        "A boot-up after the other, the parameters gone: to be given up after some attempts.",
        {"seconds": PERIOD, "times": Parameter("how many resets; 0: no end", 0, int, low=0)},
        ResetLoop,
    ),
    "power_cycle": FaultType(
        "The supply goes, and comes back.",
        "Silence, then a boot-up without a command: to be configured and started anew.",
        {"seconds": Parameter("without supply, in s", 1.0, low=1e-6)},
        lambda place, seconds: Supply(place, seconds, 0.0, 1),
    ),
    "brown_out": FaultType(
        "The supply fails several times in a row.",
        "Boot-ups in a row; some of its configuration falls into a gap and has to be repeated.",
        {
            "seconds": Parameter("without supply, in s", 0.05, low=1e-6),
            "pause": Parameter("with supply in between, in s", 0.2, low=1e-6),
            "times": Parameter("how many times", 3, int, low=1),
        },
        Supply,
    ),
    "duplicate_node_id": FaultType(
        "A second device of the same kind and node id is on the bus, as it is delivered.",
        "Two boot-ups, two heartbeats, two answers to each request: an error of the installation.",
        {},
        Duplicate,
    ),
    "wrong_identity": FaultType(
        "The identity object 0x1018 has another value.",
        "Another device than it was told to expect: not to be started (CiA 302-2, boot-up).",
        {
            "entry": Parameter("1 vendor, 2 product, 3 revision, 4 serial", 2, int, 1, 4),
            "value": Parameter("its value", 0xBAD, int, low=0, high=0xFFFF_FFFF),
        },
        lambda place, entry, value: Counterfeit(place, (0x1018, entry), value),
    ),
    "wrong_firmware": FaultType(
        "The software version 0x100A is another one.",
        "A version it does not know: to be reported, or refused.",
        {"version": Parameter("its text", "0.0", str)},
        lambda place, version: Counterfeit(place, (0x100A, 0), version),
    ),
}
