"""Set-value ramps: from zero after a RUN command, later from one set value to the next."""

from simulators.devices.topcon.model.unit import UnitType

SLOPE_1 = 1.6  # s from zero to full scale at slope 1, by Regatron's DLL header


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
        part = dt * self._slope / SLOPE_1
        self.voltage = _toward(voltage, self.voltage, part * self._unit.nominal_voltage)
        self.current = _toward(current, self.current, part * self._unit.maximum_current)
        if self.reached(voltage, current):
            self._slope = self._unit.run_slope


def _toward(target: float, value: float, reach: float) -> float:
    if target > value:
        return min(target, value + reach)
    return max(target, value - reach)
