"""The services of one slave, from one boot to the next: who hears what, who has news."""

from collections.abc import Callable, Iterator, Sequence

from simulators.device import Device
from simulators.services import Handler, Heard, Service, State
from simulators.services.emcy import EmcyLog, EmcyProducer
from simulators.services.heartbeat import HeartbeatConsumer, HeartbeatProducer
from simulators.services.nmt import Nmt, Reset
from simulators.services.sdo import SdoServer
from simulators.services.store import Store
from simulators.services.sync import Sync
from simulators.slave import Slave


class Stack:
    """Built anew by every reset; nothing in it is cleaned by hand.

    `routes` and `publishers` are worked out for the NMT state and for the communication area as
    it is, so that a frame finds its handlers with one look.
    """

    def __init__(
        self,
        slave: Slave,
        device: Device,
        log: EmcyLog,
        listeners: Sequence[Callable[[State], None]],
    ) -> None:
        self.slave = slave
        self.state = State.INITIALISING
        self.routes: dict[Heard, list[Handler]] = {}
        self.publishers: list[Callable[[], None]] = []
        self.stale = False  # something in the communication area has changed
        self._device = device
        self._listeners = listeners
        self._nmt = Nmt(slave)
        self._heartbeat = HeartbeatProducer(slave)
        self._services = [self._nmt, self._heartbeat, *_services(slave, device, log)]
        slave.on_communication_change = self._on_communication_change
        slave.bind(device.objects)
        for service in self._services:
            slave.bind(service.objects)

    @property
    def reset(self) -> Reset | None:
        """What the NMT master wants to be reset."""
        return self._nmt.reset

    def boot_up(self) -> None:
        """Initialisation is over: say so and enter Pre-operational."""
        self._nmt.boot_up()
        self._heartbeat.start()
        self._announce(State.PRE_OPERATIONAL)

    def follow(self) -> None:
        """Enter the state the NMT master wants, then the one the device wants."""
        if self._nmt.state is not self.state:
            self._announce(self._nmt.state)
        own = self._device.nmt_state
        if own is not None and own is not self.state:
            self._nmt.state = own
            self._announce(own)

    def publish(self) -> None:
        """Follow what has been changed in the communication area, then send what is new."""
        if self.stale:
            self._derive()
        for publish in self.publishers:
            publish()

    def close(self) -> None:
        """Fall silent."""
        self.slave.clock.close()
        self._tell(State.INITIALISING)

    def _tell(self, state: State) -> None:
        for listener in self._listeners:
            listener(state)

    def _announce(self, state: State) -> None:
        self.state = state
        self._tell(state)
        for service in self._services:
            service.on_state(state)
        self._derive()

    def _on_communication_change(self) -> None:
        self.stale = True

    def _derive(self) -> None:
        self.stale = False
        self.routes, self.publishers = {}, []
        for service in self._services:
            heard = list(service.listen())
            if self.state not in service.active_in:
                continue
            for key, handle in heard:
                self.routes.setdefault(key, []).append(handle)
            if service.eventful:
                self.publishers.append(service.publish)


def _services(slave: Slave, device: Device, log: EmcyLog) -> Iterator[Service]:
    """Those that nobody but the bus asks for anything, in the order in which they speak."""
    yield HeartbeatConsumer(slave, device.on_heartbeat)
    yield SdoServer(slave)
    yield Sync(slave)
    yield from device.pdos(slave)
    yield EmcyProducer(slave, log, lambda: device.emergencies, device.farewell)
    yield Store(slave, device.memory, device.stored, device)
    yield from device.services(slave)
