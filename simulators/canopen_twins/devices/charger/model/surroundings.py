"""What is around the charger, supply and load among it; all of it is assumed."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, sqrt
from typing import NamedTuple

from canopen_twins.devices.charger.model.discharging import Bars
from canopen_twins.devices.charger.model.load import HOLDING_TIME, Electrode, Load, Web
from canopen_twins.devices.charger.model.sparks import Storm
from canopen_twins.devices.charger.model.thermal import AMBIENT
from canopen_twins.devices.charger.model.types import Mode, Type

IDLE_POWER = 5.0  # W
EFFICIENCY = 0.80  # of the charging stage
EFFICIENCY_DISCHARGING = 0.70
LINE_RESISTANCE = 0.05  # ohm
# What an ESA mode is meant for loads the bar differently: active share, leakage in S.
MATERIALS = {
    Mode.ESA_FILM: (1.0, 0.0),
    Mode.ESA_PAPER: (1.0, 2e-9),
    Mode.ESA_METALLISED: (1.3, 5e-9),
}


class Feed(NamedTuple):
    """What arrives at the supply terminals."""

    voltage: float  # V
    current: float  # A
    power: float  # W


def feed(nominal_voltage: float, charging: float, discharging: float) -> Feed:
    """Supply of `nominal_voltage` (V, without load) under the output powers given in W."""
    power = IDLE_POWER + charging / EFFICIENCY + discharging / EFFICIENCY_DISCHARGING
    # U = U0 - R P/U, solved for U; below half the voltage no power arrives any more
    rest = max(0.0, nominal_voltage**2 - 4 * LINE_RESISTANCE * power)
    voltage = (nominal_voltage + sqrt(rest)) / 2
    return Feed(voltage, power / voltage if voltage else 0.0, power)


@dataclass(frozen=True)
class Surroundings:
    """Quiet by default; nothing of it can be seen or set over the bus."""

    supply_voltage: float = 24.0  # V, without load
    ambient: float = AMBIENT  # degC
    hardware_release: bool = True
    hardware_release_discharging: bool = True
    analog: float = 0.0  # % of 20 mA or 10 V
    electrode: Electrode | None = None  # instead of the bar of the type
    active: float = 1.0  # share of the charging bar that insulating dirt leaves
    leak: float = inf  # ohm, by conductive dirt
    holding_time: float = HOLDING_TIME  # s, in which an open terminal loses its charge
    web: Web = field(default_factory=Web)
    bars: Bars = field(default_factory=Bars)
    heat: Mapping[str, float] = field(default_factory=dict)  # K, by sensor, as of a blocked fan
    storm: Storm | None = None

    def load(self, kind: Type, mode: int) -> Load:
        """What a type feeds in one of its modes."""
        active, leakage = MATERIALS.get(Mode(mode), (1.0, 0.0))
        return Load(
            electrode=self.electrode or kind.bar,
            active=self.active * active,
            leakage=1 / self.leak + leakage,
            web=self.web,
            holding_time=self.holding_time,
        )
