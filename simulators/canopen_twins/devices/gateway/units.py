"""Both units as they are delivered, what they keep without power, and DcDesk at each (7 to 9)."""

import logging
from collections.abc import Mapping

from canopen_twins.device.timing import Timing
from canopen_twins.devices.gateway import delivery
from canopen_twins.devices.gateway.model.configuration import OWN_NODE
from canopen_twins.devices.gateway.model.engine import Engine
from canopen_twins.devices.gateway.model.gateway import Gateway
from canopen_twins.devices.gateway.model.governor import Governor
from canopen_twins.devices.gateway.model.parameters import Store
from canopen_twins.devices.gateway.model.unit import Life
from canopen_twins.devices.gateway.settings import Settings
from canopen_twins.devices.gateway.traffic import Disturbance
from canopen_twins.slave.memory import Memory

log = logging.getLogger(__name__)

PARAMETERS = "parameters"
KILOWATT = 1e3  # W


class Units:
    """The system of a supply period, and what outlives it: the memory, and what disturbs.

    A unit whose parameters were saved by DcDesk has them; otherwise those it was delivered with.
    """

    def __init__(self) -> None:
        self.disturbance = Disturbance()
        self._load_step = 0.0  # kW

    def renew(
        self, settings: Settings, memory: Memory, timing: Timing, engine: Engine | None = None
    ) -> None:
        """Begin with what the memory has; the engine is as it is, or a new one that stands.

        Raises:
            UserError: it is not the memory of a gateway, or the configuration is refused.
        """
        self.system = delivery.system(settings, timing, engine)
        self._memory, self._delivered = memory, delivery.configuration(settings)
        kept = {unit: memory.load(unit) for unit in self.system.kept}
        self._saved = {unit for unit, section in kept.items() if PARAMETERS in section}
        with delivery.refusals():
            self._deliver()
            self.system.restore(kept)
        self._counts = self._counted()
        self.apply(settings)

    def apply(self, settings: Settings) -> None:
        """What surrounds the engine follows at once."""
        self.settings, governor = settings, self.system.governor
        governor.engine.load = KILOWATT * (settings.load + self._load_step)
        governor.operation.run = settings.run
        governor.operation.autostart = settings.autostart
        governor.operation.highest_speed = settings.highest_speed
        governor.operation.overspeed = settings.overspeed
        governor.operation.breaker_speed = settings.breaker_speed
        governor.operation.local_setpoint = settings.speed
        governor.operation.droop = settings.droop / 100

    def step_load(self, kilowatts: float) -> None:
        """Let consumers draw this much beside those of the settings."""
        self._load_step = kilowatts
        self.apply(self.settings)

    @property
    def parameters(self) -> Store:
        """Those of the gateway: in force, or as the next start finds them."""
        gateway = self.system.gateway
        if gateway.programme is not None:
            return gateway.store
        return gateway.parameters_of_next_start

    @property
    def node_id(self) -> int:
        """Parameter 427."""
        return self.parameters[OWN_NODE]

    def misconfigure(self, content: Mapping[str, Mapping[int, float]]) -> None:
        """Let the units have other parameters, and restart both.

        Raises:
            UserError: a parameter that is out of its range.
        """
        with delivery.refusals():
            self.system.configure(content)
        self._restart()

    def put_right(self) -> None:
        """Let the units have the parameters they should have, and restart both."""
        self._deliver()
        self._restart()

    def save(self, unit: Governor | Gateway) -> None:
        """Keep the parameters of a unit as they are."""
        self._saved.add(unit.which.value)
        self.keep()

    def keep(self) -> None:
        """Keep everything; a memory that cannot be written is reported."""
        self._counts = self._counted()
        try:
            for name, values in self.system.kept.items():
                left_out = () if name in self._saved else (PARAMETERS,)
                self._memory.store(name, {k: v for k, v in values.items() if k not in left_out})
        except OSError as failure:
            log.error("the memory cannot be written: %s", failure)

    def keep_news(self) -> None:
        """Keep everything if an error was counted since the last time."""
        if self._counts != self._counted():
            self.keep()

    def _deliver(self) -> None:
        for unit in (self.system.governor, self.system.gateway):
            name = unit.which.value
            unit.store.saved = {}
            self.system.configure({name: self._parameters(name)})

    def _parameters(self, name: str) -> Mapping[int, float]:
        if name not in self._saved:
            return self._delivered.get(name, {})
        saved: Mapping[str, float] = self._memory.load(name)[PARAMETERS]
        return {int(number): value for number, value in saved.items()}

    def _restart(self) -> None:
        if self.system.governor.life is not Life.OFF:
            self.system.power_on()

    def _counted(self) -> int:
        """How often anything was counted; a counter that stays at its end says nothing new."""
        governor, gateway = self.system.governor.memory, self.system.gateway.memory
        return sum(governor.counts.values()) + sum(gateway.counts.values())


class DcDesk:
    """Parameters by number or name: `desk["CanOpenSendStatus"] = 1`, `desk[2000]`.

    A change acts after `save` and a reset of the unit, and is lost by a reset without (7). Whatever
    is refused is a `UserError`: no such parameter, out of range, only shown, no answer.
    """

    def __init__(self, unit: Governor | Gateway, units: Units) -> None:
        self._unit, self._units = unit, units

    def __getitem__(self, key: int | str) -> float:
        with delivery.refusals():
            return self._unit.desk.read(key)

    def __setitem__(self, key: int | str, value: float) -> None:
        with delivery.refusals():
            self._unit.desk.write(key, value)

    def save(self) -> None:
        """Keep what was changed; from now on it comes before the configuration file."""
        self._unit.desk.save()
        self._units.save(self._unit)

    def reset(self) -> None:
        """Reset this unit alone, as its reset button does."""
        self._unit.reset()

    def clear_errors(self) -> None:
        """Clear all errors, in the other unit too (9.1)."""
        self._unit.desk.clear_errors()

    def clear_error_memory(self) -> None:
        """Clear the counters from 3100 upward (9.2)."""
        self._unit.desk.clear_error_memory()
        self._units.keep()

    def connect(self, node: int = 0, identifier: int = 0) -> None:
        """Plug the PC in: its node number on the HEINZMANN CAN, 0 for none, and who it is (8.3)."""
        self._unit.desk.connect(node, identifier)
