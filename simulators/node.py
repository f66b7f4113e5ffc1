"""One device on a wire: the path of a frame, from boot to boot.

`receive` finds who listens to a COB-ID; the service reads or writes the dictionary; the object
there acts on the model. Then every service publishes what has changed. Nothing calls upwards.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import inf, isfinite

from simulators.clock import MICROSECONDS, Clock, Timer, microseconds
from simulators.device import Device
from simulators.faults import Faults
from simulators.services import Handler, Heard, Service, State
from simulators.services.emcy import EmcyLog, EmcyProducer
from simulators.services.heartbeat import HeartbeatConsumer, HeartbeatProducer
from simulators.services.nmt import Nmt, Reset
from simulators.services.sdo import SdoServer
from simulators.services.store import Store, recall
from simulators.services.sync import Sync
from simulators.slave import Slave
from simulators.wire import Frame, Outbox, Wire

COMMUNICATION_AREA = range(0x1000, 0x2000)
EVERYTHING = range(0x1000, 0x10000)


class Node:
    """A device with power on or off; it needs a clock and somebody who empties the outbox."""

    def __init__(
        self, device: Device, clock: Clock, outbox: Outbox | None = None, name: str = "node"
    ) -> None:
        self.device = device
        self.clock = clock
        self.wire = Wire(clock, outbox, name)
        self.faults = Faults(device.faults)
        self.powered = False
        self.slave: Slave | None = None
        self.log = EmcyLog()
        self._services: list[Service] = []
        self._nmt: Nmt | None = None
        self._announced = State.INITIALISING
        self._afresh = True  # the next boot is one of the application, not of communication alone
        self._routes: dict[Heard, list[Handler]] = {}
        self._publishers: list[Callable[[], None]] = []
        self._stale = False
        self._cycle = microseconds(device.cycle)
        self._stepped = clock.ticks
        self._wake: float = inf
        self._timer: Timer | None = None

    @property
    def state(self) -> State:
        """The NMT state; Initialisation also means silence, whatever its reason."""
        return self._announced

    @property
    def node_id(self) -> int:
        """The node id in force, or the one to boot with."""
        return self.device.node_id if self.slave is None else self.slave.node_id

    def power_on(self) -> None:
        """Switch the supply on; without effect if it is."""
        if self.powered:
            return
        self.powered = True
        self._stepped = self.clock.ticks
        self.device.power_on()
        self.faults.renew()
        self._settle()
        self._arm()

    def power_off(self) -> None:
        """Switch the supply off: what is not in the memory is lost."""
        if self.slave is not None:
            self._fall_silent()
        if self.powered:
            self.device.power_off()
        self.powered = False
        self._afresh = True
        self._disarm()

    def receive(self, frame: Frame) -> None:
        """Take a frame from the bus; what the node sends is in the outbox afterwards."""
        handlers = self._routes.get((frame.can_id, frame.remote))
        if handlers is None or frame.extended:
            return
        self._catch_up()
        self.device.on_frame()
        for handle in handlers:
            handle(frame)
        self._settle()

    @contextmanager
    def acting(self) -> Iterator[Device]:
        """Act on the device at this moment: time has passed before, news goes out after."""
        if self.powered:
            self._catch_up()
        yield self.device
        if self.powered:
            self._settle()

    def _catch_up(self) -> None:
        elapsed = self.clock.ticks - self._stepped
        if elapsed >= self._cycle:
            elapsed -= elapsed % self._cycle
            self._stepped += elapsed
            self.device.step(elapsed / MICROSECONDS)

    def _settle(self) -> None:
        self._follow()
        for publish in self._publishers:
            publish()
        if self._stale:
            self._derive()
        if self._wake - self._stepped > self._cycle:  # it rests: does it still?
            self._arm()

    def _tick(self) -> None:
        self._catch_up()
        self._settle()
        self._arm()

    def _arm(self) -> None:
        rest = self.device.rest * MICROSECONDS
        wait = max(rest - rest % self._cycle, self._cycle) if isfinite(rest) else inf
        if self._stepped + wait == self._wake:
            return
        self._disarm()
        self._wake = self._stepped + wait
        if isfinite(wait):
            self._timer = self.clock.at_tick(int(self._wake), self._tick)

    def _disarm(self) -> None:
        self._wake = inf
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _follow(self) -> None:
        """Boot, fall silent or reset as the device and the NMT master want it."""
        if self._nmt is None:
            if self.device.online:
                self._boot()
        elif not self.device.online:
            self._fall_silent()
            self._afresh = True
        elif self._nmt.reset is not None:
            self._reset(self._nmt.reset)
        elif self._nmt.state is not self._announced:
            self._announce(self._nmt.state)

    def _reset(self, reset: Reset) -> None:
        self._fall_silent()
        self._afresh = reset is Reset.NODE
        if reset is Reset.NODE:
            self.device.reset_node()
        else:
            self.device.reset_communication()
        if self.device.online:
            self._boot()

    def _boot(self) -> None:
        """A fresh slave from the EDS and the stored parameters; nothing is cleaned by hand."""
        device = self.device
        self.slave = slave = Slave(device.dictionary(), device.node_id, self.wire, self.clock)
        slave.profile = device.profile
        slave.on_communication_change = self._on_communication_change
        self.log = EmcyLog() if self._afresh else self.log
        self._nmt, heartbeat = Nmt(slave), HeartbeatProducer(slave)
        self._services = [
            self._nmt,
            heartbeat,
            HeartbeatConsumer(slave, device.on_heartbeat),
            SdoServer(slave),
            Sync(slave),
            *device.pdos(slave),
            EmcyProducer(slave, self.log, lambda: device.emergencies, device.farewell),
            Store(slave, device.memory, device.stored),
            *device.services(slave),
        ]
        slave.bind(device.objects)
        for service in self._services:
            slave.bind(service.objects)
        area = EVERYTHING if self._afresh else COMMUNICATION_AREA
        recall(slave, device.memory, device.stored, area)
        self._nmt.boot_up()
        heartbeat.start()
        self._announce(State.PRE_OPERATIONAL)

    def _announce(self, state: State) -> None:
        self._announced = state
        self.device.on_state(state)
        for service in self._services:
            service.on_state(state)
        self._derive()

    def _fall_silent(self) -> None:
        assert self.slave is not None
        self.slave.clock.close()
        self.slave = self._nmt = None
        self._services, self._routes, self._publishers = [], {}, []
        self._announced = State.INITIALISING
        self.device.on_state(State.INITIALISING)

    def _on_communication_change(self) -> None:
        self._stale = True

    def _derive(self) -> None:
        """Who hears what in this state: once now, and not again for every frame."""
        self._stale = False
        self._routes, self._publishers = {}, []
        for service in self._services:
            heard = list(service.listen())
            if self._announced not in service.active_in:
                continue
            for key, handle in heard:
                self._routes.setdefault(key, []).append(handle)
            if service.eventful:
                self._publishers.append(service.publish)
