"""The discharging stage of the variants /A and /C, and the watch over its bars."""

from dataclasses import dataclass, field

from canopen_twins.devices.charger.model.bars import (
    CLEAN,
    Bars,
    Dirt,
    Discharge,
    active,
    at_reference_point,
    found,
    passive,
)
from canopen_twins.devices.charger.model.parameters import Parameter, Parameters
from canopen_twins.devices.charger.model.surroundings import Surroundings
from canopen_twins.devices.charger.model.ticks import NEVER, whole_ticks
from canopen_twins.devices.charger.model.types import Type

CALIBRATION = whole_ticks(60.0)
HIGHEST_NOMINAL = 1000  # mW, the high limit of 2002h:29h
SERIES_WITH_DETECTION = ("R60", "R60L")  # 2002h:28h
OFF, MONITORING, CALIBRATING = range(3)  # values of 2002h:28h


@dataclass
class Discharging:
    """What stands at its terminals (`now`), and what was found on its bars."""

    kind: Type
    parameters: Parameters
    now: Discharge = field(default_factory=Discharge, init=False)
    dirt: tuple[Dirt, Dirt] = field(default=CLEAN, init=False)
    _calibrated: int = field(default=0, init=False)  # ticks

    def drive(self, ticks: int, surroundings: Surroundings, power: float) -> None:
        """Let time pass with the stage on, at `power` W at most."""
        bars, web = surroundings.bars, surroundings.web
        self.now = active(self.parameters, self.kind, power, web, bars)
        self._watch(ticks, bars)

    def idle(self, surroundings: Surroundings) -> None:
        """Let time pass with the stage off."""
        self.now, self.dirt = passive(surroundings.web), CLEAN

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
