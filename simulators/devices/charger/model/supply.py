"""The supply: what the charger draws, and what arrives then (all figures assumed)."""

from math import sqrt
from typing import NamedTuple

IDLE_POWER = 5.0  # W
EFFICIENCY = 0.80  # of the charging stage
EFFICIENCY_DISCHARGING = 0.70
LINE_RESISTANCE = 0.05  # ohm


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
