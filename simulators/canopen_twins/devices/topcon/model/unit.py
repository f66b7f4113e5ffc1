"""Types of TopCon units: the figures on the type plate and what is assumed behind them."""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from functools import cached_property
from math import isfinite, pi
from typing import Literal

Connection = Literal["parallel", "series"]

FULL_SCALE = 4000  # parts that make up a nominal value (7.3.5)
LARGEST = 0x7FFF  # 0x2000-0x2003 are signed 16-bit values (7.3.1-7.3.4)
SHOWN = {  # the objects 0x2000-0x2003 hold whole numbers of these
    "nominal_voltage": (1.0, "V"),
    "maximum_current": (1.0, "A"),
    "nominal_power": (1e3, "kW"),
    "nominal_resistance": (1e-3, "mOhm"),
}
MAY_BE_ZERO = ("idle_power", "sink_current", "overvoltage_delay", "overcurrent_delay")


@dataclass(frozen=True, kw_only=True)
class UnitType:
    """One unit, or a system of units seen as one.

    Raises ValueError when the figures do not fit the objects that show them (7.3.1-7.3.4).
    """

    name: str
    nominal_voltage: float  # V, whole
    maximum_current: float  # A, whole
    nominal_power: float  # W, whole kW
    nominal_resistance: float  # ohm, whole mOhm; the scale of 0x2013
    capacitance: float  # F, output filter
    bleeder: float  # ohm, base load across it
    start_slope: float  # 1..32000; slope 1 takes 1.6 s from zero to full scale
    run_slope: float
    overvoltage_delay: float  # s
    overcurrent_delay: float  # s
    i2t_current: float  # A, carried for ever
    i2t_limit: float  # A2s on top of it
    efficiency: float  # 0..1
    idle_power: float  # W, lost with the output on
    thermal_resistance: float  # K/W, heat sink to ambient
    thermal_capacity: float  # J/K
    sink_current: float = 0.0  # A into the unit; 0 = one quadrant, else the Q4 option
    regenerative: bool = False  # with IBC: it watches the mains itself, not the DC link
    control_bandwidth: float = 2000.0  # Hz; what it drives lasts so long when a load lets go

    def __post_init__(self) -> None:
        if complaint := next(self._complaints(), ""):
            raise ValueError(f"unit type {self.name!r}: {complaint}")

    @cached_property
    def droop(self) -> float:
        """Ohm that stand for the finite gain of the voltage loop: 0.1 part at full current."""
        return 0.1 * self.nominal_voltage / FULL_SCALE / self.maximum_current

    @cached_property
    def control_delay(self) -> float:
        """Seconds until the converter has followed a load that lets go."""
        return 1.0 / (2.0 * pi * self.control_bandwidth)

    def system(self, count: int, connection: Connection) -> "UnitType":
        """Figures of `count` equal units that act as one (7.3.1, A-74)."""
        if count < 1 or connection not in ("parallel", "series"):
            raise ValueError(f"{count} units in {connection}: 1 or more, in parallel or series")
        if count == 1:
            return self
        return (_parallel if connection == "parallel" else _series)(self, count)

    def _complaints(self) -> Iterator[str]:
        for name in (field.name for field in fields(self) if field.type is float):
            value = getattr(self, name)
            if not isfinite(value) or value < 0 or (value == 0 and name not in MAY_BE_ZERO):
                yield f"{name} must be above 0, not {value:g}"
        for name, (scale, unit) in SHOWN.items():
            shown = getattr(self, name) / scale
            if abs(shown - round(shown)) > 1e-9 * shown or shown > LARGEST:
                yield f"{name} must be a whole number of {unit} up to {LARGEST}, not {shown:g}"
        if self.efficiency > 1:
            yield f"efficiency must be in 0..1, not {self.efficiency:g}"
        if not all(1 <= slope <= 32000 for slope in (self.start_slope, self.run_slope)):
            yield f"slopes must be in 1..32000, not {self.start_slope:g} and {self.run_slope:g}"


def _parallel(unit: UnitType, count: int) -> UnitType:
    return replace(
        _together(unit, count),
        name=f"{count} x {unit.name} parallel",
        maximum_current=unit.maximum_current * count,
        nominal_resistance=round(unit.nominal_resistance / count, 3),  # 0x2003 is whole mOhm
        capacitance=unit.capacitance * count,
        bleeder=unit.bleeder / count,
        i2t_current=unit.i2t_current * count,
        i2t_limit=unit.i2t_limit * count**2,
        sink_current=unit.sink_current * count,
    )


def _series(unit: UnitType, count: int) -> UnitType:
    return replace(
        _together(unit, count),
        name=f"{count} x {unit.name} series",
        nominal_voltage=unit.nominal_voltage * count,
        nominal_resistance=unit.nominal_resistance * count,
        capacitance=unit.capacitance / count,
        bleeder=unit.bleeder * count,
    )


def _together(unit: UnitType, count: int) -> UnitType:
    """Power and losses add up however the units are wired."""
    return replace(
        unit,
        nominal_power=unit.nominal_power * count,
        idle_power=unit.idle_power * count,
        thermal_resistance=unit.thermal_resistance / count,
        thermal_capacity=unit.thermal_capacity * count,
    )
