"""Pollution of the charging bar: its resistance, compared with that of a calibration."""

from collections import deque
from dataclasses import dataclass, field

from canopen_twins.devices.charger.model.parameters import Parameter, Parameters, half_up
from canopen_twins.devices.charger.model.ticks import NEVER, whole_ticks

WINDOW = whole_ticks(1.0)  # the resistance is a mean over this time (assumed)
CALIBRATION = whole_ticks(20 * 60)  # 2002h:19h
MICRO = 1_000_000
NO_CURRENT = 0xFFFF_FFFF  # ohm
OFF, MONITORING, CALIBRATING = range(3)  # values of 2002h:19h


def resistance(voltage: int, current: int) -> int:
    """Whole ohm from sums of V and of uA; without current the largest value there is (A-51)."""
    return min(NO_CURRENT, half_up(voltage * MICRO, current)) if current else NO_CURRENT


@dataclass
class Resistance:
    """The resistance of the load over the last second; sums of whole V and uA are exact."""

    _samples: deque[tuple[int, int]] = field(default_factory=lambda: deque(maxlen=WINDOW))
    _voltage: int = 0  # sums
    _current: int = 0
    _same: int = 0  # samples in a row without a difference

    @property
    def value(self) -> int:
        """Ohm; 0 with high voltage off (A-51)."""
        return resistance(self._voltage, self._current) if self._samples else 0

    def add(self, ticks: int, voltage: int, current: int) -> None:
        """Take the same sample `ticks` times over, in V and uA."""
        same = bool(self._samples) and self._samples[-1] == (voltage, current)
        if same and self._same >= WINDOW:
            return
        self._same = (self._same if same else 0) + ticks
        for _ in range(min(ticks, WINDOW)):
            if len(self._samples) == WINDOW:
                self._voltage -= self._samples[0][0]
                self._current -= self._samples[0][1]
            self._samples.append((voltage, current))
            self._voltage += voltage
            self._current += current

    def clear(self) -> None:
        """High voltage is off."""
        self._samples.clear()
        self._voltage = self._current = self._same = 0

    @property
    def quiet(self) -> int:
        """Ticks until it changes."""
        return NEVER if self._same >= WINDOW or not self._samples else 1


@dataclass
class Calibration:
    """Twenty minutes with high voltage on that give 2002h:1Ah (2002h:19h, A-60)."""

    _elapsed: int = 0  # ticks
    _voltage: int = 0  # sums of V and uA
    _current: int = 0

    def restart(self) -> None:
        """Forget what was collected."""
        self._elapsed = self._voltage = self._current = 0

    def add(self, ticks: int, voltage: int, current: int) -> None:
        """Time has passed with high voltage on; a ramp counts as time but gives no values."""
        self._elapsed += ticks
        self._voltage += ticks * voltage
        self._current += ticks * current

    @property
    def done(self) -> bool:
        """Whether the time is over."""
        return self._elapsed >= CALIBRATION

    @property
    def result(self) -> int:
        """The nominal resistance in ohm; never 0, which would mean none."""
        return max(1, resistance(self._voltage, self._current))

    @property
    def quiet(self) -> int:
        """Ticks of high voltage until it is done."""
        return CALIBRATION - self._elapsed


def calibrating(parameters: Parameters) -> bool:
    """Whether a calibration is under way or waits: asked for, or because none has been (A-60)."""
    wanted = parameters[Parameter.POLLUTION_DETECTION]
    return wanted == CALIBRATING or (
        wanted == MONITORING and not parameters[Parameter.NOMINAL_RESISTOR]
    )


def pollution(parameters: Parameters, present: int) -> int:
    """How far the resistance (ohm) is from its nominal, in %, 100 at most (A-61)."""
    nominal = parameters[Parameter.NOMINAL_RESISTOR]
    if parameters[Parameter.POLLUTION_DETECTION] == OFF or calibrating(parameters) or not present:
        return 0
    return min(100, half_up(100 * abs(present - nominal), nominal))
