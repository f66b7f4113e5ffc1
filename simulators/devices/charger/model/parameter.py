"""The parameters, numbered as in the manual, and the limits that refer to other parameters."""

from collections.abc import Mapping
from enum import Enum, IntEnum

from simulators.devices.charger.model.types import Quantity


class Parameter(IntEnum):
    """What a master sets, numbered as in the manual; each value is a whole number of its unit."""

    RELEASE_MODE = 0x02  # bits of `Source`
    ANALOG_SETPOINT = 0x03
    RELEASE_TIMEOUT = 0x04  # ms
    VOLTAGE_SETPOINT = 0x08  # V
    CURRENT_SETPOINT = 0x09  # uA
    SETPOINT_PERCENT = 0x0B  # %
    VOLTAGE_MINIMUM = 0x0C  # V
    VOLTAGE_MAXIMUM = 0x0D
    CURRENT_MINIMUM = 0x0E  # uA
    CURRENT_MAXIMUM = 0x0F
    MODE = 0x10
    RAMP_TIME = 0x11  # ms
    WEB_WIDTH = 0x12  # mm
    WEB_WIDTH_MINIMUM = 0x13
    WEB_WIDTH_MAXIMUM = 0x14
    CURRENT_WIDTH_FACTOR = 0x15  # uA/m
    STRONG_SPARKS = 0x16  # %
    WEAK_SPARKS = 0x17
    SPARKS_LIMIT = 0x18
    POLLUTION_DETECTION = 0x19
    NOMINAL_RESISTOR = 0x1A  # ohm
    LIMITER_WARNING = 0x1B
    KEYBOARD_LOCK = 0x1C
    VOLTAGE_SETPOINT_DISCHARGING = 0x1E  # V
    SETPOINT_PERCENT_DISCHARGING = 0x21  # %
    MODE_DISCHARGING = 0x22
    ADJUSTMENT_DISCHARGING = 0x25  # %
    FREQUENCY_DISCHARGING = 0x26
    SOFTWARE_RELEASE_DISCHARGING = 0x27
    POLLUTION_DETECTION_DISCHARGING = 0x28
    NOMINAL_POWER_1 = 0x29  # mW
    NOMINAL_POWER_2 = 0x2A


# The entry that is the limit of another, lower and upper; constant limits are in the dictionary.
LIMITS: Mapping[Parameter, tuple[Parameter | None, Parameter | None]] = {
    Parameter.VOLTAGE_SETPOINT: (Parameter.VOLTAGE_MINIMUM, Parameter.VOLTAGE_MAXIMUM),
    Parameter.VOLTAGE_MINIMUM: (None, Parameter.VOLTAGE_MAXIMUM),
    Parameter.VOLTAGE_MAXIMUM: (Parameter.VOLTAGE_MINIMUM, None),
    Parameter.CURRENT_SETPOINT: (Parameter.CURRENT_MINIMUM, Parameter.CURRENT_MAXIMUM),
    Parameter.CURRENT_MINIMUM: (None, Parameter.CURRENT_MAXIMUM),
    Parameter.CURRENT_MAXIMUM: (Parameter.CURRENT_MINIMUM, None),
    Parameter.WEB_WIDTH: (Parameter.WEB_WIDTH_MINIMUM, Parameter.WEB_WIDTH_MAXIMUM),
    Parameter.WEB_WIDTH_MINIMUM: (None, Parameter.WEB_WIDTH_MAXIMUM),
    Parameter.WEB_WIDTH_MAXIMUM: (Parameter.WEB_WIDTH_MINIMUM, None),
}
SETPOINT = {
    Quantity.VOLTAGE: Parameter.VOLTAGE_SETPOINT,
    Quantity.CURRENT: Parameter.CURRENT_SETPOINT,
}


class Direction(Enum):
    """On which side a value lies outside."""

    LOW = "below"
    HIGH = "above"


class OutOfRange(ValueError):  # noqa: N818 - a refusal is an answer of the device, not an error
    """A value beyond the limit that another parameter sets; nothing has changed."""

    def __init__(self, value: int, direction: Direction, limit: int, of: Parameter) -> None:
        super().__init__(f"{value} is {direction.value} {limit} (0x2002:{of.value:02X})")
        self.direction = direction
