"""The output node: filter capacitor, bleeder, converter and load, step by step."""

from simulators.devices.topcon.model.loads import Load, Open
from simulators.devices.topcon.model.modes import Mode
from simulators.devices.topcon.model.solver import Law, Solution, solve
from simulators.devices.topcon.model.unit import UnitType

AGES = 1e9  # s: one implicit step of this length ends in the steady state
STILL = 1e-9  # of full scale per step: slow enough to ask where it will end
ARRIVED = 1e-6  # of full scale: 0.004 parts, nobody can see the rest of the way


class Circuit:
    """Voltage in V across the output, current in A into the load."""

    def __init__(self, unit: UnitType) -> None:
        self._unit = unit
        self._load: Load = Open()
        self.voltage = 0.0
        self.current = 0.0
        self.mode = Mode.OFF
        self.drift = 0.0  # of full scale, during the last step
        self.settled = True

    def disturb(self) -> None:
        """Another law holds from now on."""
        self.settled = False

    def step(self, dt: float, law: Law | None, load: Load) -> None:
        """`dt` seconds under one law; where nothing is left to happen, the steady state exactly."""
        if load is not self._load:
            self._load, self.current = load, 0.0  # a winding just connected carries nothing
        after = self._after(dt, law)
        self.drift = self._distance(after)
        self._adopt(after)
        self.settled = False
        if self.drift <= STILL:
            end = self._after(AGES, law)
            self.settled = self._distance(end) <= ARRIVED
            if self.settled:
                self._adopt(end)

    def _after(self, dt: float, law: Law | None) -> Solution:
        line = self._load.line(self.voltage, self.current, dt)
        unit = self._unit
        return solve(law, self.voltage, unit.capacitance / dt, 1.0 / unit.bleeder, line)

    def _distance(self, other: Solution) -> float:
        return max(
            abs(other.voltage - self.voltage) / self._unit.nominal_voltage,
            abs(other.current - self.current) / self._unit.maximum_current,
        )

    def _adopt(self, solution: Solution) -> None:
        self.voltage, self.current, self.mode = solution
