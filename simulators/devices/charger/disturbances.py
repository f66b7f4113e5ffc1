"""What goes wrong around a charger: each makes other surroundings of those that are there.

Parameters come from users; what cannot be is refused with `UserError`.
"""

from dataclasses import replace

from simulators.devices.charger.model.load import OPEN, SHORT
from simulators.devices.charger.model.storm import Storm
from simulators.devices.charger.model.surroundings import Surroundings
from simulators.errors import UserError, unknown

MEGA, PERCENT = 1e6, 1e-2
LOWEST_SUPPLY, HIGHEST_SUPPLY = 6.0, 40.0  # V
SENSORS = ("power_stage", "inside", "cascade", "discharging")
CONNECTORS = (1, 2)


def spark_storm(
    around: Surroundings, rate: float, seed: int, breakdown: float, scale: float
) -> Surroundings:
    """Sparks at random; `scale` 0 V: the voltage does not matter."""
    if rate < 0 or scale < 0:
        raise UserError("a storm has a rate and a scale of 0 or more")
    storm = Storm(rate, seed, breakdown, scale) if scale else Storm(rate, seed)
    return replace(around, storm=storm)


def short(around: Surroundings) -> Surroundings:
    """The electrode is at earth."""
    return replace(around, electrode=SHORT)


def open_electrode(around: Surroundings) -> Surroundings:
    """The electrode is not there."""
    return replace(around, electrode=OPEN)


def conductive_pollution(around: Surroundings, megaohm: float) -> Surroundings:
    """A leak beside the corona."""
    return replace(around, leak=_positive("megaohm", megaohm) * MEGA)


def insulating_pollution(around: Surroundings, percent: float) -> Surroundings:
    """So much of the bar is covered."""
    return replace(around, active=1 - _share(percent))


def discharging_pollution(around: Surroundings, connector: int, percent: float) -> Surroundings:
    """A discharging bar takes so much of the power of a clean one."""
    if connector not in CONNECTORS:
        raise UserError(f"discharging bars are connected to 1 and 2, not to {connector}")
    power, (first, second) = _positive("percent", percent) * PERCENT, around.bars.power
    powers = (power, second) if connector == 1 else (first, power)
    return replace(around, bars=around.bars._replace(power=powers))


def hardware_release_lost(around: Surroundings) -> Surroundings:
    """The contact of the charging is open."""
    return replace(around, hardware_release=False)


def discharging_release_lost(around: Surroundings) -> Surroundings:
    """The contact of the discharging is open."""
    return replace(around, hardware_release_discharging=False)


def analog(around: Surroundings, percent: float) -> Surroundings:
    """The analog input is driven."""
    return replace(around, analog=_share(percent) / PERCENT)


def supply(around: Surroundings, volts: float) -> Surroundings:
    """Another voltage, without load."""
    if not LOWEST_SUPPLY <= volts <= HIGHEST_SUPPLY:
        raise UserError(f"a supply of {volts} V: 6..40 V; without any the power is off")
    return replace(around, supply_voltage=volts)


def overtemperature(around: Surroundings, sensor: str, kelvin: float) -> Surroundings:
    """A sensor reads so much more than the losses explain."""
    if sensor not in SENSORS:
        raise unknown("sensor", sensor, SENSORS)
    return replace(around, heat=around.heat._replace(**{sensor: kelvin}))


def _share(percent: float) -> float:
    if not 0 <= percent <= 100:
        raise UserError(f"{percent} % is not in 0..100")
    return percent * PERCENT


def _positive(what: str, value: float) -> float:
    if value <= 0:
        raise UserError(f"{what} is above 0, not {value}")
    return value
