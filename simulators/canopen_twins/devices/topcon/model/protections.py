"""What the unit is watched for: conditions, the errors they become, and which errors stay."""

from collections.abc import Callable, Iterator
from math import ceil
from typing import NamedTuple

from canopen_twins.devices.topcon.model.plant import Inputs, Plant
from canopen_twins.devices.topcon.model.thermal import HOT, WARM
from canopen_twins.devices.topcon.model.unit import UnitType

MAINS_LOW, MAINS_HIGH = 340.0, 460.0  # V between lines (assumed); DC link at 459 V and 621 V
FREQUENCY_LOW, FREQUENCY_HIGH = 48.0, 62.0  # Hz (assumed)
MAINS_DELAY = 0.02  # s (assumed)
TRANSIENT = 0.15  # of the voltage, within a millisecond (assumed)
NEAR = 0.05  # of a limit (assumed)
MAINS_NEARLY_LOW, MAINS_NEARLY_HIGH = MAINS_LOW * (1 + NEAR), MAINS_HIGH * (1 - NEAR)

HAIR = 1e-9  # of full scale: a regulated value is at its level but for the last bit
DERATED_MARGIN = 1.05  # over the derated maximum (assumed)
DERATED_DELAY = 0.01  # s (assumed)
SENSE_MARGIN = 0.05  # of the nominal voltage: more than a drop on cables explains (assumed)
SLAVE_DELAY = 0.1  # s (assumed)

SLAVE_SILENT = 0x67  # Tab. 78
SLAVE_NUMBER = 0xDA  # Tab. 77
WRONG_COUNT = {"series": 0xD5, "parallel": 0xD6}  # Tab. 76

Condition = Callable[[Plant], bool]


class Protection(NamedTuple):
    """A condition that becomes an error when it lasts; the error can be reset once it is over."""

    error: int
    """Error number of chapter 8."""
    condition: Condition
    delay: float = 0.0  # s
    armed: Condition = lambda _: True
    stays: Condition = lambda _: False
    """What keeps the error once it is there, beside its condition."""


class Rail(NamedTuple):
    """A supply inside the unit: its range of 10 % (assumed), and the errors below and above."""

    low: float  # V
    high: float
    low_error: int
    high_error: int

    def protections(self, name: str) -> Iterator[Protection]:
        """Without a sign, so that below is nearer to 0."""
        sign = 1 if self.low > 0 else -1
        nominal, low, high = (self.low + self.high) / 2, sign * self.low, sign * self.high
        yield Protection(
            self.low_error, lambda plant: sign * plant.supplies.get(name, nominal) < low
        )
        yield Protection(
            self.high_error, lambda plant: sign * plant.supplies.get(name, nominal) > high
        )


RAILS = {  # Tab. 69
    "24V": Rail(21.6, 26.4, 0x4B, 0x4C),
    "15V": Rail(13.5, 16.5, 0x45, 0x46),
    "-15V": Rail(-13.5, -16.5, 0x47, 0x48),
    "5V": Rail(4.5, 5.5, 0x43, 0x44),
}


def mains_low(plant: Plant) -> bool:
    """The lower end of the range."""
    return plant.mains < MAINS_LOW


def mains_high(plant: Plant) -> bool:
    """The upper end of the range."""
    return plant.mains > MAINS_HIGH


def mains_jumped(plant: Plant) -> bool:
    """Up or down; what was there before power-on is no jump."""
    jump = abs(plant.mains - plant.mains_before)
    return plant.ticks > 1 and jump > TRANSIENT * plant.mains_before


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


def above_sink_level(plant: Plant) -> bool:
    """The level of 7.3.15 for the current that a Q4 unit takes in."""
    hair = HAIR * plant.unit.maximum_current
    return plant.running and plant.circuit.current < -plant.overcurrent_level - hair


def above_derated_sink(plant: Plant) -> bool:
    """As for the current that it gives."""
    warm = plant.running and plant.heat.temperature > WARM
    derated = plant.heat.derating * plant.unit.sink_current
    return warm and plant.circuit.current < -DERATED_MARGIN * derated


def too_hot(plant: Plant) -> bool:
    """The heat sink at its limit."""
    return plant.heat.temperature >= HOT


def still_hot(plant: Plant) -> bool:
    """It has to cool down before a reset helps."""
    return plant.heat.temperature > HOT - plant.cooldown


def sense_differs(plant: Plant) -> bool:
    """What is in the sense lines that is not at the terminals."""
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


DC_LINK = (  # an uncontrolled rectifier: 1.35 times the mains, so the mains stand for it
    Protection(0x49, mains_low, MAINS_DELAY),  # Tab. 69
    Protection(0x4A, mains_high, MAINS_DELAY),
    Protection(0x4D, mains_jumped),
)
IBC = (  # a regenerating input stage holds the DC link itself and watches the mains
    Protection(0x145, mains_low, MAINS_DELAY),  # Tab. 68
    Protection(0x144, mains_high, MAINS_DELAY),
    Protection(0x143, lambda plant: plant.mains_frequency < FREQUENCY_LOW, MAINS_DELAY),
    Protection(0x142, lambda plant: plant.mains_frequency > FREQUENCY_HIGH, MAINS_DELAY),
)


def of_output(unit: UnitType) -> Iterator[Protection]:
    """The rows for what moves by itself: the output, heat, the I2t store."""
    yield Protection(0x30, above_voltage_level, unit.overvoltage_delay, watching_voltage)  # Tab. 70
    yield Protection(0x21, above_current_level, unit.overcurrent_delay)  # Tab. 67
    yield Protection(0x25, above_derated_current, DERATED_DELAY)
    yield Protection(0x20, lambda plant: plant.store.charge >= unit.i2t_limit)
    if unit.sink_current:
        yield Protection(0x29, above_sink_level, unit.overcurrent_delay)
        yield Protection(0x2A, above_derated_sink, DERATED_DELAY)
    yield Protection(0x51, too_hot, stays=still_hot)  # Tab. 71


def of_surroundings(unit: UnitType) -> Iterator[Protection]:
    """The rows for what is done to the unit from outside."""
    yield Protection(0x31, sense_differs)  # Tab. 70
    yield Protection(0x33, sense_negative)
    yield from IBC if unit.regenerative else DC_LINK
    for name, rail in RAILS.items():
        yield from rail.protections(name)
    yield Protection(0xF2, lambda plant: not plant.interlock_closed)  # Tab. 83
    yield Protection(SLAVE_SILENT, slave_missing, SLAVE_DELAY)


def is_at_ease(plant: Plant) -> bool:
    """Whether at a glance no row of the output holds, and nothing warns.

    Most ticks are such, and nobody has to go through the rows.
    """
    voltage, current = plant.circuit.voltage, plant.circuit.current
    return (
        voltage <= plant.overvoltage_level
        and voltage <= plant.overvoltage_warning
        and -plant.overcurrent_level <= current <= plant.overcurrent_level
        and current <= plant.overcurrent_warning
        and plant.heat.temperature < WARM
        and plant.store.charge < plant.unit.i2t_limit / 2
    )


def is_left_alone(plant: Plant) -> bool:
    """The same of the rows of the surroundings."""
    return (
        plant.interlock_closed
        and MAINS_NEARLY_LOW <= plant.mains <= MAINS_NEARLY_HIGH
        and plant.mains == plant.mains_before
        and FREQUENCY_LOW <= plant.mains_frequency <= FREQUENCY_HIGH
        and not plant.supplies
        and not plant.sense_offset
        and not plant.sense_reversed
        and not plant.slave_silent
    )


def warns(plant: Plant) -> bool:
    """Whether there is a reason for bit 14 of 0x2023; no message tells it (A-53)."""
    unit, current = plant.unit, plant.circuit.current
    return (
        plant.heat.temperature >= WARM
        or plant.store.charge >= unit.i2t_limit / 2
        or plant.circuit.voltage > plant.overvoltage_warning
        or (plant.running and current > plant.overcurrent_warning)
        or not MAINS_NEARLY_LOW <= plant.mains <= MAINS_NEARLY_HIGH
    )


class Watch:
    """Counts ticks of `tick` seconds; one without the condition starts the count again."""

    def __init__(self, unit: UnitType, tick: float) -> None:
        self._of_output = tuple(of_output(unit))
        self._rows = (*self._of_output, *of_surroundings(unit))  # errors come in this order
        self._enough = [max(1, ceil(row.delay / tick - 1e-9)) for row in self._rows]
        self._lasted: dict[int, int] = {}  # ticks, by place in the table

    def step(self, plant: Plant) -> None:
        """Look at the plant, at the end of a tick."""
        rows = self._of_output if is_left_alone(plant) else self._rows
        self._lasted = {
            place: self._lasted.get(place, 0) + 1
            for place, row in enumerate(rows)
            if row.condition(plant) and row.armed(plant)
        }

    def start_again(self) -> None:
        """Nothing lasts, at the end of a tick."""
        self._lasted = {}

    @property
    def errors(self) -> list[int]:
        """Error numbers of what has lasted long enough, in the order of the table."""
        lasted = self._lasted.items()
        return [self._rows[at].error for at, ticks in lasted if ticks >= self._enough[at]]

    @property
    def pending(self) -> bool:
        """Whether a condition lasts, but not yet long enough."""
        lasted = self._lasted
        return bool(lasted) and any(ticks < self._enough[at] for at, ticks in lasted.items())

    def persists(self, error: int, plant: Plant) -> bool:
        """Whether the cause of an error is still there."""
        rows = (row for row in self._rows if row.error == error)
        return any(row.condition(plant) or row.stays(plant) for row in rows)


class Latches:
    """`errors` in the order they came, and `warning`."""

    def __init__(self, stage: Inputs, tick: float) -> None:
        self._one_short = [WRONG_COUNT[stage.connection], SLAVE_NUMBER]
        self._watch = Watch(stage.unit, tick)
        self._held: list[int] = []
        self.errors: list[int] = []
        self.warning = False

    @property
    def pending(self) -> bool:
        """Whether something may become an error within its delay."""
        return self._watch.pending

    def step(self, plant: Plant) -> None:
        """Latch what has lasted long enough, at the end of a tick."""
        if is_at_ease(plant) and is_left_alone(plant):
            self._watch.start_again()
            return
        self._watch.step(plant)
        for error in self._watch.errors:
            self.latch(error)
        self.warning = self.warning or warns(plant)

    def latch(self, error: int) -> None:
        """Note an error, once."""
        known = error == SLAVE_SILENT and SLAVE_NUMBER in self.errors
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
        if SLAVE_SILENT in left and slave_missing(plant):
            left.remove(SLAVE_SILENT)  # the system counts its units anew: one is missing
            left += self._one_short
        self.errors = left
        self.warning = warns(plant)

    def _persists(self, error: int, plant: Plant) -> bool:
        return (
            error in self._held
            or (error in self._one_short and slave_missing(plant))
            or self._watch.persists(error, plant)
        )
