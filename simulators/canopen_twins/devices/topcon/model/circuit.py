"""The voltage at the output: ramped set values, and one implicit Euler step in closed form.

    storage * (u - u_before) + u * bleeder + load(u) = converter(u)

Left side rising, right side falling: there is one solution. Each limit of the converter makes
a root of its own; the least of them holds. Under them all lies a floor: idling, or the limit of
the current that a Q4 unit takes in.
"""

from math import inf, sqrt
from typing import NamedTuple

from canopen_twins.devices.topcon.model.loads import Line, Load, Open
from canopen_twins.devices.topcon.model.states import Mode
from canopen_twins.devices.topcon.model.unit import UnitType

SLOPE_1 = 1.6  # s from zero to full scale at slope 1, by Regatron's DLL header
AGES = 1e9  # s: one implicit step of this length ends in the steady state
STILL = 1e-9  # of full scale per step: slow enough to ask where it will end
ARRIVED = 1e-6  # of full scale: 0.004 parts, nobody can see the rest of the way
GLIDING = 1e-2  # of full scale per second: nothing but a stored charge moves so slowly
STRIDE = 1e-4  # of full scale: as far as it may get in one step then
LONGEST = 60.0  # s: the longest such step


class Ramps:
    """Ramped set values in V and A. Power and resistance act at once, without a ramp."""

    def __init__(self, unit: UnitType) -> None:
        self._unit = unit
        self.restart()

    def restart(self) -> None:
        """Forget the set values reached; the start slope holds until both are reached again."""
        self.voltage = self.current = 0.0
        self._slope = self._unit.start_slope

    def reached(self, voltage: float, current: float) -> bool:
        """Whether nothing is left to ramp, once these are the set values."""
        return self.voltage == voltage and self.current == current

    def step(self, dt: float, voltage: float, current: float) -> None:
        """Approach the set values for `dt` seconds."""
        if not self.reached(voltage, current):
            part = dt * self._slope / SLOPE_1
            self.voltage = _toward(voltage, self.voltage, part * self._unit.nominal_voltage)
            self.current = _toward(current, self.current, part * self._unit.maximum_current)
        if self.reached(voltage, current):
            self._slope = self._unit.run_slope


def _toward(target: float, value: float, reach: float) -> float:
    if target > value:
        return min(target, value + reach)
    return max(target, value - reach)


class Law(NamedTuple):
    """What the converter regulates at the terminals while it is on."""

    voltage: float  # V, the ramped set value
    resistance: float  # ohm
    current: float  # A, the ramped set value or the derated maximum
    power: float  # W
    sink: float  # A it can take in at the terminals; 0 for one that cannot


class Solution(NamedTuple):
    """The output at the end of a step."""

    voltage: float  # V
    current: float  # A into the load
    mode: Mode


def solve(law: Law | None, voltage: float, storage: float, bleeder: float, line: Line) -> Solution:
    """The output one step after `voltage`, in V.

    `storage` is the capacitance over the length of the step in A/V, `bleeder` the base load in
    A/V, `law` is None while the converter is off.
    """
    conductance, offset, low, high = line
    before = conductance * voltage + offset
    after, mode = _node(law, voltage, storage + conductance, bleeder, before)
    current = conductance * after + offset
    if current > high or current < low:
        current = high if current > high else low
        after, mode = _node(law, voltage, storage, bleeder, current)
    if after < 0.0:  # the output rectifier lets a winding freewheel
        after, current = 0.0, min(max(offset, low), high)
    return Solution(after, current, mode)


def _node(
    law: Law | None, voltage: float, slope: float, bleeder: float, load: float
) -> tuple[float, Mode]:
    """The node voltage when load and storage together take `load` + `slope` * change."""
    if law is None:
        return voltage - (load + bleeder * voltage) / (slope + bleeder), Mode.OFF
    by_voltage = voltage + (law.voltage - voltage - law.resistance * load) / (
        slope * law.resistance + 1.0
    )
    by_current = voltage + (law.current - load) / slope
    held, mode = by_voltage, Mode.VOLTAGE
    if by_current < by_voltage:
        held, mode = by_current, Mode.CURRENT
    if (slope * (held - voltage) + load) * held > law.power:
        held, mode = _by_power(law.power, voltage, slope, load), Mode.POWER
    if law.sink:
        by_sink = voltage - (law.sink + load) / slope
        return (by_sink, Mode.CURRENT) if by_sink > held else (held, mode)
    idle = voltage - (load + bleeder * voltage) / (slope + bleeder)
    return idle if idle > held else held, mode


def _by_power(power: float, voltage: float, slope: float, load: float) -> float:
    """Root of (load + slope * change) * (voltage + change) = power."""
    middle = slope * voltage + load
    root = sqrt((slope * voltage - load) ** 2 + 4.0 * slope * power)
    if middle > 0.0:
        return voltage + 2.0 * (power - voltage * load) / (middle + root)
    return voltage + (root - middle) / (2.0 * slope)


class Circuit:
    """Voltage in V across the output, current in A into the load."""

    def __init__(self, unit: UnitType) -> None:
        self._unit = unit
        self.load: Load = Open()
        self.voltage = 0.0
        self.current = 0.0
        self.charge = 0.0  # As into the load since it was connected
        self.mode = Mode.OFF
        self.drift = 0.0  # of full scale, during the last step
        self.settled = True
        self._length = AGES  # s, of that step

    def disturb(self) -> None:
        """Another law holds from now on."""
        self.settled, self.drift = False, inf

    def step(self, dt: float, law: Law | None, load: Load) -> None:
        """`dt` seconds under one law; where nothing is left to happen, the steady state exactly."""
        if load is not self.load:
            self._connect(load, law)
        after = self._after(dt, law)
        self.drift, self._length = self._distance(after), dt
        self._adopt(after, dt)
        self.settled = False
        if self.drift <= STILL:
            end = self._after(AGES, law)
            self.settled = self._distance(end) <= ARRIVED
            if self.settled:
                self._adopt(end, AGES)

    @property
    def stride(self) -> float:
        """Seconds that one step may take where only a stored charge moves; 0 while more does."""
        pace = self.drift / self._length
        if pace > GLIDING:
            return 0.0
        return min(STRIDE / pace, LONGEST) if pace else LONGEST

    def _connect(self, load: Load, law: Law | None) -> None:
        """What is just connected carries nothing; and what is let go has nowhere to flow.

        Until the control has followed, the converter drives what it drove, into its capacitor.
        """
        driven = self.current
        self.load, self.current, self.charge = load, 0.0, 0.0
        conductance, offset, low, high = load.line(self.voltage, 0.0, self._unit.control_delay)
        taken = min(max(conductance * self.voltage + offset, low), high)
        if law and (0.0 <= taken < driven or driven < taken <= 0.0 < law.sink):
            delay = self._unit.control_delay
            out = driven + self.voltage / self._unit.bleeder
            line = conductance, offset - out, low - out, high - out
            after = solve(
                None, self.voltage, self._unit.capacitance / delay, 1.0 / self._unit.bleeder, line
            )
            self.voltage, self.current = after.voltage, after.current + out

    def _after(self, dt: float, law: Law | None) -> Solution:
        line = self.load.line(self.voltage, self.current, dt, self.charge)
        unit = self._unit
        return solve(law, self.voltage, unit.capacitance / dt, 1.0 / unit.bleeder, line)

    def _distance(self, other: Solution) -> float:
        voltage = abs(other.voltage - self.voltage) / self._unit.nominal_voltage
        current = abs(other.current - self.current) / self._unit.maximum_current
        return current if current > voltage else voltage

    def _adopt(self, solution: Solution, dt: float) -> None:
        self.voltage, self.current, self.mode = solution
        self.charge += self.current * dt
