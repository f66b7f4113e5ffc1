"""What surrounds the charger: its supply, its inputs, its electrodes, and what disturbs them."""

from dataclasses import dataclass, field
from math import inf

from simulators.devices.charger.model.bars import Bars
from simulators.devices.charger.model.load import Electrode, Load, Web
from simulators.devices.charger.model.storm import Storm
from simulators.devices.charger.model.thermal import AMBIENT, Heat
from simulators.devices.charger.model.types import Mode, Type

# What an ESA mode is meant for loads the bar differently: active share, leakage in S.
MATERIALS = {
    Mode.ESA_FILM: (1.0, 0.0),
    Mode.ESA_PAPER: (1.0, 2e-9),
    Mode.ESA_METALLISED: (1.3, 5e-9),
}


@dataclass(frozen=True)
class Surroundings:
    """Quiet by default; nothing of it can be seen or set over the bus, all of it is assumed."""

    supply_voltage: float = 24.0  # V, without load
    ambient: float = AMBIENT  # degC
    hardware_release: bool = True
    hardware_release_discharging: bool = True
    analog: float = 0.0  # % of 20 mA or 10 V
    electrode: Electrode | None = None  # instead of the bar of the type
    active: float = 1.0  # share of the charging bar that insulating dirt leaves
    leak: float = inf  # ohm, by conductive dirt
    web: Web = field(default_factory=Web)
    bars: Bars = field(default_factory=Bars)
    heat: Heat = field(default_factory=Heat)
    storm: Storm | None = None

    def load(self, kind: Type, mode: int) -> Load:
        """What a type feeds in one of its modes."""
        active, leakage = MATERIALS.get(Mode(mode), (1.0, 0.0))
        return Load(
            electrode=self.electrode or kind.bar,
            active=self.active * active,
            leakage=1 / self.leak + leakage,
            web=self.web,
        )
