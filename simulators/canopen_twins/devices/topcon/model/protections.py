"""Watching a plant: which condition has lasted for longer than its delay."""

from collections.abc import Callable, Iterable, Iterator
from math import ceil
from typing import NamedTuple

from canopen_twins.devices.topcon.model import error_numbers as number
from canopen_twins.devices.topcon.model.plant import HOT, WARM, Inputs, Plant
from canopen_twins.devices.topcon.model.unit import UnitType

Condition = Callable[[Plant], bool]


class Protection(NamedTuple):
    """A condition that becomes an error when it lasts; the error can be reset once it is over."""

    error: int
    condition: Condition
    delay: float = 0.0  # s
    armed: Condition = lambda _: True


class Watch:
    """Counts ticks of `tick` seconds; one without the condition starts the count again."""

    def __init__(self, protections: Iterable[Protection], tick: float) -> None:
        self._protections = tuple(protections)
        self._enough = [max(1, ceil(row.delay / tick - 1e-9)) for row in self._protections]
        self._lasted: dict[int, int] = {}  # ticks, by place in the table

    def step(self, plant: Plant) -> None:
        """Look at the plant, at the end of a tick."""
        self._lasted = {
            place: self._lasted.get(place, 0) + 1
            for place, row in enumerate(self._protections)
            if row.condition(plant) and row.armed(plant)
        }

    @property
    def errors(self) -> list[int]:
        """Error numbers of what has lasted long enough, in the order of the table."""
        lasted = self._lasted.items()
        return [self._protections[at].error for at, ticks in lasted if ticks >= self._enough[at]]

    @property
    def pending(self) -> bool:
        """Whether a condition lasts, but not yet long enough."""
        return any(ticks < self._enough[at] for at, ticks in self._lasted.items())

    def persists(self, error: int, plant: Plant) -> bool:
        """Whether the cause of an error is still there."""
        return any(row.error == error and row.condition(plant) for row in self._protections)


MAINS_LOW, MAINS_HIGH = 340.0, 460.0  # V between lines (assumed)
FREQUENCY_LOW, FREQUENCY_HIGH = 48.0, 62.0  # Hz (assumed)
DELAY = 0.02  # s (assumed)
TRANSIENT = 0.15  # of the voltage, within a millisecond (assumed)
NEAR = 0.05  # of a limit (assumed)


def mains_low(plant: Plant) -> bool:
    """DC link under 459 V."""
    return plant.mains < MAINS_LOW


def mains_high(plant: Plant) -> bool:
    """DC link over 621 V."""
    return plant.mains > MAINS_HIGH


def mains_jumped(plant: Plant) -> bool:
    """Up or down; what was there before power-on is no jump."""
    jump = abs(plant.mains - plant.mains_before)
    return plant.ticks > 1 and jump > TRANSIENT * plant.mains_before


def mains_near_a_limit(plant: Plant) -> bool:
    """On the way out of the permitted range, or outside."""
    return not MAINS_LOW * (1 + NEAR) <= plant.mains <= MAINS_HIGH * (1 - NEAR)


DC_LINK = (  # an uncontrolled rectifier: 1.35 times the mains, so the mains stand for it
    Protection(number.DC_LINK_LOW, mains_low, DELAY),
    Protection(number.DC_LINK_HIGH, mains_high, DELAY),
    Protection(number.DC_LINK_TRANSIENT, mains_jumped),
)

IBC = (  # a regenerating input stage holds the DC link itself and watches the mains
    Protection(number.MAINS_LOW, mains_low, DELAY),
    Protection(number.MAINS_HIGH, mains_high, DELAY),
    Protection(
        number.MAINS_FREQUENCY_LOW, lambda plant: plant.mains_frequency < FREQUENCY_LOW, DELAY
    ),
    Protection(
        number.MAINS_FREQUENCY_HIGH, lambda plant: plant.mains_frequency > FREQUENCY_HIGH, DELAY
    ),
)

AUXILIARY = (  # 10 % around each nominal voltage (assumed)
    Protection(number.SUPPLY_24V_LOW, lambda plant: plant.supply_24v < 21.6),
    Protection(number.SUPPLY_24V_HIGH, lambda plant: plant.supply_24v > 26.4),
    Protection(number.SUPPLY_5V_LOW, lambda plant: plant.supply_5v < 4.5),
    Protection(number.SUPPLY_5V_HIGH, lambda plant: plant.supply_5v > 5.5),
    Protection(number.SUPPLY_15V_LOW, lambda plant: plant.supply_15v < 13.5),
    Protection(number.SUPPLY_15V_HIGH, lambda plant: plant.supply_15v > 16.5),
    Protection(number.SUPPLY_MINUS_15V_LOW, lambda plant: plant.supply_minus_15v > -13.5),
    Protection(number.SUPPLY_MINUS_15V_HIGH, lambda plant: plant.supply_minus_15v < -16.5),
)


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
    yield from IBC if unit.regenerative else DC_LINK
    yield from AUXILIARY
    yield Protection(number.INTERLOCK_OPEN, lambda plant: not plant.interlock_closed)
    yield Protection(number.SLAVE_SILENT, slave_missing, SLAVE_DELAY)


WARNINGS: tuple[Condition, ...] = (  # bit 14 of 0x2023, no message
    lambda plant: plant.heat.temperature >= WARM,
    lambda plant: plant.store.charge >= plant.unit.i2t_limit / 2,
    lambda plant: plant.circuit.voltage > plant.overvoltage_warning,
    lambda plant: plant.running and plant.circuit.current > plant.overcurrent_warning,
    mains_near_a_limit,
)


class Latches:
    """`errors` in the order they came, and `warning`."""

    def __init__(self, stage: Inputs, tick: float) -> None:
        count = number.PARALLEL_COUNT if stage.connection == "parallel" else number.SERIES_COUNT
        self._one_short = [count, number.SLAVE_NUMBER]
        self._watch = Watch(protections(stage.unit), tick)
        self._held: list[int] = []
        self.errors: list[int] = []
        self.warning = False

    @property
    def pending(self) -> bool:
        """Whether something may become an error within its delay."""
        return self._watch.pending

    def step(self, plant: Plant) -> None:
        """Latch what has lasted long enough, at the end of a tick."""
        self._watch.step(plant)
        for error in self._watch.errors:
            self.latch(error)
        self.warning = self.warning or _warns(plant)

    def latch(self, error: int) -> None:
        """Note an error, once."""
        known = error == number.SLAVE_SILENT and number.SLAVE_NUMBER in self.errors
        if error not in self.errors and not known:
            self.errors.append(error)

    def hold(self, error: int) -> None:
        """Give an error a cause that lasts until `release`."""
        if error not in self._held:
            self._held.append(error)

    def release(self, error: int) -> None:
        """End a cause given by `hold`."""
        if error in self._held:
            self._held.remove(error)

    def reset(self, plant: Plant) -> None:
        """Forget what has no cause any more (A-49)."""
        left = [error for error in self.errors if self._persists(error, plant)]
        if number.SLAVE_SILENT in left and slave_missing(plant):
            left.remove(number.SLAVE_SILENT)  # the system counts its units anew: one is missing
            left += self._one_short
        self.errors = left
        self.warning = _warns(plant)

    def _persists(self, error: int, plant: Plant) -> bool:
        return (
            error in self._held
            or (error in self._one_short and slave_missing(plant))
            or self._watch.persists(error, plant)
        )


def _warns(plant: Plant) -> bool:
    return any(condition(plant) for condition in WARNINGS)
