"""CANopen side of the gateway: PDOs, its partner, and the values the object dictionary holds."""

from simulators.devices.gateway.model.canopen_bus import (
    BootUp,
    CanopenBus,
    Heartbeat,
    Plug,
    TpdoFrame,
)
from simulators.devices.gateway.model.dictionary import PARTNER_NODE, Entry
from simulators.devices.gateway.model.heartbeat import Consumer
from simulators.devices.gateway.model.outputs import Outputs
from simulators.devices.gateway.model.state import COMMUNICATING, Machine, State
from simulators.devices.gateway.model.store import Store
from simulators.devices.gateway.model.timing import MOST_HEARTBEAT_CYCLES, cycles

HEARTBEAT_PERIOD, HEARTBEAT_LIMIT = 429, 430


class CanopenSide:
    """Which service works is decided by the state machine and by the health of the bus."""

    def __init__(
        self, plug: Plug, machine: Machine, settings: Store, cycle: int, *, always_armed: bool
    ) -> None:
        self.bus = CanopenBus(plug)
        self.outputs: Outputs | None = None
        """The values of the object dictionary, while there is one."""
        self._machine = machine
        self._digital = (0, 0)  # errors and engine state, told even before there is a dictionary
        self._beats = bool(settings[HEARTBEAT_PERIOD])
        limit = cycles(settings[HEARTBEAT_LIMIT], cycle, MOST_HEARTBEAT_CYCLES)
        self.consumer = Consumer(limit if settings[PARTNER_NODE] else 0, always_armed)

    @property
    def listening(self) -> bool:
        """Whether NMT is heard; the other services depend on the state."""
        return self._machine.state in COMMUNICATING and self.bus.alive

    @property
    def operational(self) -> bool:
        """Whether PDOs are exchanged."""
        return self.listening and self._machine.state is State.OPERATIONAL

    def create(self, outputs: Outputs) -> None:
        """The init telegrams were accepted: there is a dictionary now."""
        outputs.show(*self._digital)
        self.outputs = outputs

    def boot_up(self) -> None:
        """Pre-Operational was entered from Init."""
        self.bus.send(BootUp())

    def begin_operation(self) -> None:
        """Operational was entered."""
        self.consumer.begin()
        if self.outputs is not None:
            self.outputs.begin()

    def step(self) -> None:
        """One main cycle: the partner's heartbeat, and the health of the bus."""
        state = self._machine.state
        self.consumer.step(state)
        failed = self.bus.failed
        self.bus.step()
        if failed and not self.bus.failed and state in COMMUNICATING:
            self.bus.send(Heartbeat(state) if self._beats else BootUp())

    def partner_heartbeat(self) -> None:
        """A heartbeat of the watched partner, its boot-up included (A-19)."""
        if self.bus.alive:
            self.consumer.receive()

    def mapped(self, rpdo: int) -> tuple[Entry, ...]:
        """The entries of an RPDO 1..4 that is taken; none if it is not active, or nothing is."""
        if self.outputs is None or not self.operational:
            return ()
        pdo = self.outputs.dictionary.rpdos.get(rpdo)
        return () if pdo is None else pdo.entries

    def show(self, present: int, engine: int) -> None:
        """Errors and engine state of this cycle of the governor."""
        self._digital = present, engine
        if self.outputs is None:
            return
        self.outputs.show(present, engine)
        if self.operational:
            for frame in self.outputs.news:
                self.bus.send(frame)

    def send_tpdo(self, number: int, words: tuple[int, ...]) -> None:
        """An analogue TPDO of the governor: keep its values, and send it on in Operational."""
        if self.outputs is None:
            return
        self.outputs.take(self.outputs.dictionary.tpdos[number].entries, words)
        if self.operational:
            self.bus.send(TpdoFrame(number, words))
