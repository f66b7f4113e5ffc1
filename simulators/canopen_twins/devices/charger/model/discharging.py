"""The discharging stage of the variants /A and /C, its bars, and what dirt does to them."""

from dataclasses import dataclass, field
from enum import IntEnum
from math import pi, sqrt
from typing import NamedTuple

from canopen_twins.devices.charger.model.load import Web
from canopen_twins.devices.charger.model.parameters import (
    CALIBRATING,
    MONITORING,
    OFF,
    Parameter,
    Parameters,
)
from canopen_twins.devices.charger.model.ticks import NEVER, whole_ticks
from canopen_twins.devices.charger.model.types import Type

FREQUENCIES = [500 / n for n in (10, 9, 8, 7, 6, 5, 4, 3, 2)]  # Hz, by the index 2002h:26h
BAR_CAPACITANCE = 0.6e-9  # F (assumed, as everything below)
ACTIVE_SHARE = 0.05  # of the apparent power
PASSIVE_SHARE = 0.3  # of the charge that a bar without voltage takes off
ADJUSTMENT_SHARE = 0.05  # of the alternating current, as direct current at 100 % of 2002h:25h
CONDUCTIVE_ABOVE, INSULATING_BELOW = 1.5, 0.5  # of the nominal power
CALIBRATION = whole_ticks(60.0)
APPROACH = whole_ticks(1.0)  # at the reference point, so often
BETWEEN = whole_ticks(600.0)
HIGHEST_NOMINAL = 1000  # mW, the high limit of 2002h:29h
SERIES_WITH_DETECTION = ("R60", "R60L")  # 2002h:28h


class Dirt(IntEnum):
    """What was found on a bar (6000h:07h and 08h)."""

    NONE = 0
    CONDUCTIVE = 1
    INSULATING = 2


CLEAN = (Dirt.NONE, Dirt.NONE)


class Bars(NamedTuple):
    """The discharging bars: their series and, as a factor, the power each takes."""

    series: str = "R60"
    power: tuple[float, float] = (1.0, 1.0)


class Discharge(NamedTuple):
    """What stands at the discharging terminals; the defaults are those of a passive bar."""

    voltage: float = 0.0  # V rms
    current: float = 0.0  # A rms
    direct_current: float = 0.0  # A, signed
    powers: tuple[float, float] = (0.0, 0.0)  # W, by connector
    limited: bool = False

    @property
    def power(self) -> float:
        """W."""
        return sum(self.powers)


def passive(web: Web) -> Discharge:
    """Grounded bars take off a part of what the web brings along."""
    return Discharge(direct_current=-PASSIVE_SHARE * _brought(web))


class OperatingPoint(NamedTuple):
    """What is asked of the stage."""

    voltage: float  # V rms
    frequency: float  # Hz


def reference_point(kind: Type) -> OperatingPoint:
    """Highest voltage and lowest frequency, whatever is set (2002h:28h, A-81)."""
    return OperatingPoint(float(kind.maximum_voltage_discharging), FREQUENCIES[0])


def set_point(parameters: Parameters) -> OperatingPoint:
    """As 2002h:1Eh and 26h have it."""
    return OperatingPoint(
        float(parameters[Parameter.VOLTAGE_SETPOINT_DISCHARGING]),
        FREQUENCIES[parameters[Parameter.FREQUENCY_DISCHARGING]],
    )


def active(  # noqa: PLR0913 - everything that acts on the output
    wanted: OperatingPoint,
    adjustment: int,
    kind: Type,
    power_setpoint: float,
    *,
    web: Web,
    bars: Bars,
) -> Discharge:
    """What is wanted, unless the current or the power (W) allow less; `adjustment` in %."""
    conductance = _conductance(wanted.frequency)
    allowed = min(
        kind.current_discharging * 1e-6 / conductance,
        sqrt(power_setpoint / (ACTIVE_SHARE * conductance)),
    )
    voltage = min(wanted.voltage, allowed)
    current = voltage * conductance
    offset = adjustment / 100 * ADJUSTMENT_SHARE * current
    powers = _powers(voltage, current, bars)
    limited = allowed < wanted.voltage
    return Discharge(voltage, current, offset - _brought(web), powers, limited)


def found(power: float, nominal: int) -> Dirt:
    """What a power (W) at the reference point tells beside its nominal (mW)."""
    if not nominal:
        return Dirt.NONE
    share = power * 1000 / nominal
    if share > CONDUCTIVE_ABOVE:
        return Dirt.CONDUCTIVE
    return Dirt.INSULATING if share < INSULATING_BELOW else Dirt.NONE


def _conductance(frequency: float) -> float:
    return 2 * pi * frequency * BAR_CAPACITANCE


def _powers(voltage: float, current: float, bars: Bars) -> tuple[float, float]:
    each = ACTIVE_SHARE * voltage * current / 2
    return each * bars.power[0], each * bars.power[1]


def _brought(web: Web) -> float:
    return web.surface_charge * web.area_rate


@dataclass
class Discharging:
    """What stands at its terminals (`now`), and what was found on its bars."""

    kind: Type
    parameters: Parameters
    now: Discharge = field(default_factory=Discharge, init=False)
    dirt: tuple[Dirt, Dirt] = field(default=CLEAN, init=False)
    _calibrated: int = field(default=0, init=False)  # ticks
    _elapsed: int = field(default=0, init=False)  # ticks since the bars are watched
    _at_reference: bool = field(default=False, init=False)  # watched, and as it should be for that

    @property
    def _detection(self) -> int:
        return self.parameters[Parameter.POLLUTION_DETECTION_DISCHARGING]

    def drive(self, ticks: int, bars: Bars, web: Web, power: float) -> None:
        """Let time pass with the stage on, at `power` W at most."""
        watched = bars.series in SERIES_WITH_DETECTION and self._detection != OFF
        self._elapsed = self._elapsed + ticks if watched else 0
        wanted, reference = set_point(self.parameters), reference_point(self.kind)
        if watched and (self._detection == CALIBRATING or self._approaches):
            wanted = reference
        adjustment = self.parameters[Parameter.ADJUSTMENT_DISCHARGING]
        self.now = active(wanted, adjustment, self.kind, power, web=web, bars=bars)
        self._at_reference = watched and wanted == reference and not self.now.limited
        if not watched:
            self.dirt = CLEAN
        elif self._at_reference:
            self._watch(ticks)

    def coast(self, ticks: int) -> None:
        """The same for ticks in which nothing acts on it, and nothing is over."""
        if self._elapsed:
            self._elapsed += ticks
        if self._at_reference and self._detection == CALIBRATING:
            self._calibrated += ticks

    def idle(self, web: Web) -> None:
        """Let time pass with the stage off."""
        self.now, self.dirt, self._elapsed = passive(web), CLEAN, 0

    def restart_calibration(self) -> None:
        """2002h:28h was written."""
        self._calibrated = self._elapsed = 0

    def quiet(self, on: bool) -> int:
        """Ticks until a calibration is over, or the reference point is approached or left."""
        if not on or not self._elapsed:
            return NEVER
        if self._detection == CALIBRATING:
            return NEVER if self.now.limited else CALIBRATION - self._calibrated
        if set_point(self.parameters) == reference_point(self.kind):
            return NEVER
        return (APPROACH if self._approaches else BETWEEN) - self._since_approach

    @property
    def _since_approach(self) -> int:
        return (self._elapsed - 1) % BETWEEN

    @property
    def _approaches(self) -> bool:
        return self._since_approach < APPROACH

    def _watch(self, ticks: int) -> None:
        """At the reference point: compare with the nominal powers, or find them."""
        if self._detection == CALIBRATING:
            self._calibrate(ticks, self.now.powers)
        if self._detection == MONITORING:
            self.dirt = (
                found(self.now.powers[0], self.parameters[Parameter.NOMINAL_POWER_1]),
                found(self.now.powers[1], self.parameters[Parameter.NOMINAL_POWER_2]),
            )
        else:
            self.dirt = CLEAN

    def _calibrate(self, ticks: int, powers: tuple[float, float]) -> None:
        self._calibrated += ticks
        if self._calibrated < CALIBRATION:
            return
        nominal = [min(HIGHEST_NOMINAL, round(1000 * power)) for power in powers]
        self.parameters.load(
            {
                Parameter.NOMINAL_POWER_1: nominal[0],
                Parameter.NOMINAL_POWER_2: nominal[1],
                Parameter.POLLUTION_DETECTION_DISCHARGING: MONITORING,
            }
        )
