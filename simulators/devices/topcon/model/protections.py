"""What can go wrong with the output of a unit, and when it is time to warn."""

from collections.abc import Iterator

from simulators.devices.topcon.model import error_numbers as number
from simulators.devices.topcon.model import supply
from simulators.devices.topcon.model.heat import HOT, WARM
from simulators.devices.topcon.model.plant import Plant
from simulators.devices.topcon.model.unit import UnitType
from simulators.devices.topcon.model.watch import Condition, Protection

HAIR = 1e-9  # of full scale: a regulated value is at its level but for the last bit
DERATED_MARGIN = 1.05  # over the derated maximum (assumed)
DERATED_DELAY = 0.01  # s (assumed)
SENSE_MARGIN = 0.05  # of the nominal voltage (assumed)
SLAVE_DELAY = 0.1  # s (assumed)


def above_voltage_level(plant: Plant) -> bool:
    """Strictly (7.3.14, A-54)."""
    hair = HAIR * plant.unit.nominal_voltage
    return plant.circuit.voltage > plant.overvoltage_level + hair


def above_current_level(plant: Plant) -> bool:
    """Strictly (7.3.15, A-55); with the output off it is not the unit that drives the current."""
    hair = HAIR * plant.unit.maximum_current
    return plant.running and plant.circuit.current > plant.overcurrent_level + hair


def above_derated_current(plant: Plant) -> bool:
    """Only for a moment in normal operation, as the current limit follows the temperature."""
    warm = plant.running and plant.heat.temperature > WARM
    return warm and plant.circuit.current > DERATED_MARGIN * plant.derated_maximum


def sense_differs(plant: Plant) -> bool:
    """More than a voltage drop on cables explains."""
    band = SENSE_MARGIN * plant.unit.nominal_voltage
    return not plant.sense_reversed and abs(plant.sense_offset) > band


def sense_negative(plant: Plant) -> bool:
    """Sense lines interchanged, and enough voltage on them to tell."""
    band = SENSE_MARGIN * plant.unit.nominal_voltage
    return plant.sense_reversed and plant.circuit.voltage > band


def slave_missing(plant: Plant) -> bool:
    """A single unit has no slaves."""
    return plant.units > 1 and plant.slave_silent


def watching_voltage(plant: Plant) -> bool:
    """Always, or with the output on only (A-57)."""
    return plant.running or plant.overvoltage_when_off


def protections(unit: UnitType) -> Iterator[Protection]:
    """The rows one type of unit is watched by, in the order their errors are reported."""
    yield Protection(
        number.OVERVOLTAGE, above_voltage_level, unit.overvoltage_delay, watching_voltage
    )
    yield Protection(number.OVERCURRENT, above_current_level, unit.overcurrent_delay)
    yield Protection(number.DERATED_OVERCURRENT, above_derated_current, DERATED_DELAY)
    yield Protection(number.I2T, lambda plant: plant.store.charge >= unit.i2t_limit)
    yield Protection(number.IGBT_TEMPERATURE, lambda plant: plant.heat.temperature >= HOT)
    yield Protection(number.SENSE_DIFFERENCE, sense_differs)
    yield Protection(number.SENSE_REVERSED, sense_negative)
    yield from supply.IBC if unit.regenerative else supply.DC_LINK
    yield from supply.AUXILIARY
    yield Protection(number.INTERLOCK_OPEN, lambda plant: not plant.interlock_closed)
    yield Protection(number.SLAVE_SILENT, slave_missing, SLAVE_DELAY)


WARNINGS: tuple[Condition, ...] = (  # bit 14 of 0x2023, no message
    lambda plant: plant.heat.temperature >= WARM,
    lambda plant: plant.store.charge >= plant.unit.i2t_limit / 2,
    lambda plant: plant.circuit.voltage > plant.overvoltage_warning,
    lambda plant: plant.running and plant.circuit.current > plant.overcurrent_warning,
    supply.mains_near_a_limit,
)
