"""The cycle in which the charger sends its actual values (2002h:01h)."""

from collections.abc import Mapping, Sequence

from simulators.clock import Timer
from simulators.objects import Address, Object
from simulators.services import Service, State
from simulators.services.tpdo import Tpdo
from simulators.slave import Slave

CYCLE = (0x2002, 0x01)  # ms


class ActualValueTransfer(Service):
    """Sends every TPDO once a cycle; the first set they send themselves in Operational (A-24)."""

    def __init__(self, slave: Slave, tpdos: Sequence[Tpdo]) -> None:
        super().__init__(slave)
        self._tpdos = tpdos
        self._operational = False
        self._timer: Timer | None = None

    @property
    def objects(self) -> Mapping[Address, Object]:
        """A new cycle begins with the write."""
        return {CYCLE: Object(write=self._start)}

    def on_state(self, state: State) -> None:
        """PDOs are for Operational only."""
        self._operational = state is State.OPERATIONAL
        self._start(self.slave.number(*CYCLE))

    def _start(self, milliseconds: int) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = None
        if self._operational:
            self._timer = self.slave.clock.every(milliseconds / 1000, self._send)

    def _send(self) -> None:
        for tpdo in self._tpdos:
            tpdo.transmit()
