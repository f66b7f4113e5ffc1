"""The discharging stage of the variants /A and /C, its bars, and what dirt does to them."""

from dataclasses import dataclass, field
from enum import IntEnum
from math import pi, sqrt
from typing import NamedTuple

from canopen_twins.devices.charger.model.load import Web
from canopen_twins.devices.charger.model.parameters import (
    CALIBRATING,
    MONITORING,
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


def active(
    parameters: Parameters, kind: Type, power_setpoint: float, web: Web, bars: Bars
) -> Discharge:
    """The setpoint, unless the current or the power (W) allow less."""
    conductance = _conductance(FREQUENCIES[parameters[Parameter.FREQUENCY_DISCHARGING]])
    wanted = float(parameters[Parameter.VOLTAGE_SETPOINT_DISCHARGING])
    allowed = min(
        kind.current_discharging * 1e-6 / conductance,
        sqrt(power_setpoint / (ACTIVE_SHARE * conductance)),
    )
    voltage = min(wanted, allowed)
    current = voltage * conductance
    offset = parameters[Parameter.ADJUSTMENT_DISCHARGING] / 100 * ADJUSTMENT_SHARE * current
    powers = _powers(voltage, current, bars)
    return Discharge(voltage, current, offset - _brought(web), powers, allowed < wanted)


def at_reference_point(kind: Type, bars: Bars) -> tuple[float, float]:
    """Power of each connector (W) at highest voltage and lowest frequency, whatever is set."""
    voltage = float(kind.maximum_voltage_discharging)
    return _powers(voltage, voltage * _conductance(FREQUENCIES[0]), bars)


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

    def drive(self, ticks: int, bars: Bars, web: Web, power: float) -> None:
        """Let time pass with the stage on, at `power` W at most."""
        self.now = active(self.parameters, self.kind, power, web, bars)
        self._watch(ticks, bars)

    def idle(self, web: Web) -> None:
        """Let time pass with the stage off."""
        self.now, self.dirt = passive(web), CLEAN

    def restart_calibration(self) -> None:
        """2002h:28h was written."""
        self._calibrated = 0

    def quiet(self, on: bool) -> int:
        """Ticks until a calibration is over."""
        calibrating = self.parameters[Parameter.POLLUTION_DETECTION_DISCHARGING] == CALIBRATING
        return CALIBRATION - self._calibrated if on and calibrating else NEVER

    def _watch(self, ticks: int, bars: Bars) -> None:
        """Compare with the nominal powers, or find them; other bars than R60 tell nothing."""
        self.dirt = CLEAN
        if bars.series not in SERIES_WITH_DETECTION:
            return
        powers = at_reference_point(self.kind, bars)
        if self.parameters[Parameter.POLLUTION_DETECTION_DISCHARGING] == CALIBRATING:
            self._calibrate(ticks, powers)
        if self.parameters[Parameter.POLLUTION_DETECTION_DISCHARGING] == MONITORING:
            self.dirt = (
                found(powers[0], self.parameters[Parameter.NOMINAL_POWER_1]),
                found(powers[1], self.parameters[Parameter.NOMINAL_POWER_2]),
            )

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
