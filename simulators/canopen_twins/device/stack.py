"""The services of a device on its wire, from one boot to the next."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import UNCONFIGURED
from canopen_twins.bus.wire import Heard
from canopen_twins.device.device import Device
from canopen_twins.device.measurement import Measurement
from canopen_twins.device.timing import request_buffer
from canopen_twins.errors import UserError
from canopen_twins.slave.emcy import EmcyConsumer, EmcyLog, EmcyProducer
from canopen_twins.slave.error_control import (
    CommunicationErrors,
    HeartbeatConsumer,
    HeartbeatProducer,
    NodeGuarding,
)
from canopen_twins.slave.lss import LssSlave
from canopen_twins.slave.nmt import Nmt, Reset
from canopen_twins.slave.object import COMMUNICATION_AREA, Address, Object
from canopen_twins.slave.sdo_server import FurtherSdoServer, SdoServer
from canopen_twins.slave.service import Handler, Service, State
from canopen_twins.slave.slave import Slave
from canopen_twins.slave.store import ConfigurationCheck, Store, StoredEds, recall
from canopen_twins.slave.sync import Sync
from canopen_twins.slave.time import Time


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
        area: range,
    ) -> None:
        """`area` is what comes back from the memory."""
        self.slave = slave
        self.state = State.INITIALISING
        self.routes: dict[Heard, list[Handler]] = {}
        self.publishers: list[Callable[[], None]] = []
        self.stale = False  # something in the communication area has changed
        self._device = device
        self._listeners = listeners
        kept, timing = device.stored, device.timing
        self._nmt = Nmt(slave)
        self._heartbeat = HeartbeatProducer(slave)
        self._emcy = EmcyProducer(slave, log, lambda: device.emergencies, device.farewell)
        others = _services(slave, device, self._emcy, self._nmt, kept)
        self._services: list[Service] = [self._nmt, self._heartbeat, *others]
        self._unconfigured = slave.node_id == UNCONFIGURED
        if self._unconfigured:
            self._services = [each for each in self._services if isinstance(each, LssSlave)]
        slave.on_communication_change = self._on_communication_change
        slave.hear = self._hear
        _bind(slave, device)
        self.measurement: Measurement | None = None
        if timing.measures:
            self.measurement = Measurement(slave, device.measured, timing, device.cycle)
        recall(slave, device.memory, kept, area)  # what a service fixes was right when it was kept
        for service in self._services:
            slave.bind(_its_own(slave, service))

    @property
    def reset(self) -> Reset | None:
        """What the NMT master wants to be reset, or the node itself."""
        return Reset.COMMUNICATION if self.slave.restart else self._nmt.reset

    def boot_up(self) -> None:
        """Initialisation is over: say so and enter Pre-operational, if there is a node id."""
        if self.slave.node_id == UNCONFIGURED:
            self._derive()
            return
        self._nmt.boot_up()
        self._heartbeat.start()
        self._announce(State.PRE_OPERATIONAL)
        if self._nmt.starts_by_itself:
            self._nmt.state = State.OPERATIONAL
            self._announce(State.OPERATIONAL)

    def follow(self) -> None:
        """Enter the state the NMT master wants, then the one the device wants."""
        if self._unconfigured:
            return
        if self._nmt.state is not self.state:
            self._announce(self._nmt.state)
        own = self._device.nmt_state
        if own is not None and own is not self.state:
            self._nmt.state = own
            self._announce(own)

    def tell(self) -> None:
        """Tell what is wrong before the next handler of a frame may end it."""
        self._emcy.publish()

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

    def _hear(self, frame: Frame) -> None:
        for handle in self.routes.get((frame.can_id, frame.remote), ()):
            handle(frame)

    def _on_communication_change(self) -> None:
        self.stale = True

    def _derive(self) -> None:
        self.stale = False
        self.routes, self.publishers = {}, []
        self.slave.wire.listen(self.routes)
        for service in self._services:
            heard = list(service.listen())
            if self.state not in service.active_in:
                continue
            for key, handle in heard:
                self.routes.setdefault(key, []).append(handle)
            if service.eventful:
                self.publishers.append(service.publish)


def _bind(slave: Slave, device: Device) -> None:
    objects = device.objects
    for index, subindex in objects:
        if not slave.has(index, subindex):
            raise UserError(
                f"{type(device).__name__}: its EDS {Path(device.eds).name} has no entry"
                f" 0x{index:04X}:{subindex:02X}, which is among its objects"
            )
    slave.bind(objects, type(device).__name__)


def _its_own(slave: Slave, service: Service) -> Mapping[Address, Object]:
    """Without what a file has of another type than the standard: that is memory only."""
    return {
        address: acts
        for address, acts in service.objects.items()
        if service.any_type
        or address[0] not in COMMUNICATION_AREA
        or slave.entry(*address).is_whole
    }


def _services(
    slave: Slave, device: Device, emcy: EmcyProducer, nmt: Nmt, kept: Collection[Address]
) -> Iterator[Service]:
    """Those that nobody but the bus asks for anything, in the order in which they speak."""
    timing = device.timing
    errors = CommunicationErrors(slave, nmt)
    yield errors
    yield NodeGuarding(slave, errors)
    yield HeartbeatConsumer(slave, errors, device.on_heartbeat)
    yield SdoServer(slave, request_buffer(slave, timing, device.on_request_lost))
    yield from FurtherSdoServer.all(slave)
    yield Sync(slave)
    yield Time(slave)
    yield from device.pdos(slave)
    yield emcy
    yield EmcyConsumer(slave, device.on_emcy)
    busy_time = timing.store_time if timing.store_refuses else 0.0
    yield Store(slave, device.memory, kept, device, busy_time)
    yield StoredEds(slave, device.eds)
    yield from device.services(slave)
    yield ConfigurationCheck(slave, kept)  # the last: it hears of what nobody has refused
