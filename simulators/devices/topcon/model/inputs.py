"""Everything about an output stage that is set from outside, at any time, by plain assignment."""

from dataclasses import KW_ONLY, dataclass, field
from math import inf

from simulators.devices.topcon.model.loads import Load, Open
from simulators.devices.topcon.model.unit import Connection, UnitType

LEVEL_MARGIN = 1.1  # protection levels at power-on, as parts: 4400


@dataclass(eq=False)
class Inputs:
    """Set values and surroundings, in V, A, W, ohm, s, Hz and degC.

    `unit` is one unit when it comes in and the figures of the whole system of `units` after that.
    """

    unit: UnitType
    _: KW_ONLY
    load: Load = field(default_factory=Open)
    ambient: float = 25.0
    units: int = 1  # fixed from here to `seed` once the stage is powered
    connection: Connection = "parallel"
    boot_time: float = 0.0
    overvoltage_when_off: bool = True
    noise: float = 0.0  # parts up and down in every reading
    seed: int = 0

    voltage_reference: float = 0.0  # A-42, as the next ones
    current_reference: float = 0.0
    power_reference: float = field(init=False)
    resistance_reference: float = 0.0
    overvoltage_level: float = field(init=False)
    overcurrent_level: float = field(init=False)
    overvoltage_warning: float = inf  # off by default
    overcurrent_warning: float = inf

    mains: float = 400.0  # V between lines
    mains_frequency: float = 50.0
    supply_24v: float = 24.0
    supply_5v: float = 5.0
    supply_15v: float = 15.0
    supply_minus_15v: float = -15.0
    interlock_closed: bool = True
    slave_silent: bool = False  # a unit of the system does not answer the master
    sense_offset: float = 0.0  # V at the sense lines that are not at the terminals
    sense_reversed: bool = False

    def __post_init__(self) -> None:
        self.unit = self.unit.system(self.units, self.connection)
        self.power_reference = self.unit.nominal_power
        self.overvoltage_level = LEVEL_MARGIN * self.unit.nominal_voltage
        self.overcurrent_level = LEVEL_MARGIN * self.unit.maximum_current
