"""What watches the feeding side: mains, DC link, auxiliary supplies."""

from simulators.devices.topcon.model import error_numbers as number
from simulators.devices.topcon.model.plant import Plant
from simulators.devices.topcon.model.watch import Protection

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
