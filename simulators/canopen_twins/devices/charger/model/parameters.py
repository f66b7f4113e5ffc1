"""The parameters, numbered as in the manual, and the limits that refer to other parameters."""

from collections.abc import Callable, Mapping
from enum import Enum, IntEnum

from canopen_twins.devices.charger.model.types import Mode, Quantity, Type


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


OFF, MONITORING, CALIBRATING = range(3)  # values of 2002h:19h and 28h
SHORTEST_TIMEOUT = 500  # ms; 2002h:04h: anything shorter is none


class Parameters:
    """All values at this moment."""

    def __init__(self, kind: Type, values: Mapping[Parameter, int]) -> None:
        self._kind = kind
        self._values = dict(values)

    def __getitem__(self, parameter: Parameter) -> int:
        return self._values[parameter]

    @property
    def governing(self) -> Quantity:
        """What the setpoint of the present mode stands for (2002h:0Bh)."""
        return Quantity.CURRENT if self[Parameter.MODE] == Mode.I_CONST else Quantity.VOLTAGE

    def load(self, values: Mapping[Parameter, int]) -> None:
        """Take values over as they once were, without limits and without conversions."""
        self._values.update(values)

    def write(self, parameter: Parameter, value: int) -> None:
        """Set one parameter, and with it what depends on it.

        Raises:
            OutOfRange: beyond the limit that another parameter sets.
        """
        low, high = LIMITS.get(parameter, (None, None))
        if high is not None and value > self[high]:
            raise OutOfRange(value, Direction.HIGH, self[high], high)
        if low is not None and value < self[low]:
            raise OutOfRange(value, Direction.LOW, self[low], low)
        self._put(parameter, value)

    def percent_of_maximum(self, percent: float) -> int:
        """A percentage of the governing maximum limit, raised to the minimum (2002h:0Bh, A-52)."""
        return self._inside(
            SETPOINT[self.governing], half_up(percent * self._governing_maximum, 100)
        )

    @property
    def _governing_maximum(self) -> int:
        limit = LIMITS[SETPOINT[self.governing]][1]
        assert limit is not None
        return self[limit]

    def _put(self, parameter: Parameter, value: int) -> None:
        self.load({parameter: value})
        if parameter in AFTER:
            AFTER[parameter](self)

    def _inside(self, parameter: Parameter, value: int) -> int:
        low, high = LIMITS[parameter]
        assert low is not None
        assert high is not None
        return max(self[low], min(value, self[high]))

    def pull_inside(self, parameter: Parameter) -> None:
        """A limit that has moved past a value takes it along (2002h:13h and 14h, A-55)."""
        value = self._inside(parameter, self[parameter])
        if value != self[parameter]:
            self._put(parameter, value)

    def lower(self, quantity: Quantity) -> None:
        """Another highest limit is another 100 %, and may take its setpoint along (A-52)."""
        self.pull_inside(SETPOINT[quantity])
        self.to_percent(quantity)

    def from_percent(self) -> None:
        """2002h:0Bh: the governing setpoint follows the percentage."""
        setpoint = self.percent_of_maximum(self[Parameter.SETPOINT_PERCENT])
        self.load({SETPOINT[self.governing]: setpoint})

    def to_percent(self, quantity: Quantity) -> None:
        """The percentage follows the setpoint if that is the governing one (A-52)."""
        if quantity is self.governing:
            percent = half_up(100 * self[SETPOINT[quantity]], self._governing_maximum)
            self.load({Parameter.SETPOINT_PERCENT: percent})

    def from_percent_discharging(self) -> None:
        """2002h:21h: a percentage of the highest voltage of the type."""
        kind = self._kind
        percent = self[Parameter.SETPOINT_PERCENT_DISCHARGING]
        voltage = half_up(percent * kind.maximum_voltage_discharging, 100)
        voltage = max(voltage, kind.minimum_voltage_discharging)
        self.load({Parameter.VOLTAGE_SETPOINT_DISCHARGING: voltage})

    def to_percent_discharging(self) -> None:
        """The other way round, as with the charging."""
        voltage = self[Parameter.VOLTAGE_SETPOINT_DISCHARGING]
        percent = half_up(100 * voltage, self._kind.maximum_voltage_discharging)
        self.load({Parameter.SETPOINT_PERCENT_DISCHARGING: percent})

    def from_web_width(self) -> None:
        """2002h:12h: the current setpoint follows a width other than 0, cut to whole uA (A-53)."""
        if self[Parameter.WEB_WIDTH]:
            current = self[Parameter.WEB_WIDTH] * self[Parameter.CURRENT_WIDTH_FACTOR] // 1000
            self._put(Parameter.CURRENT_SETPOINT, self._inside(Parameter.CURRENT_SETPOINT, current))

    def drop_short_timeout(self) -> None:
        """2002h:04h."""
        if self[Parameter.RELEASE_TIMEOUT] < SHORTEST_TIMEOUT:
            self.load({Parameter.RELEASE_TIMEOUT: 0})


def half_up(numerator: float, denominator: int) -> int:
    """A quotient rounded to whole numbers, halves upwards (A-52)."""
    return int((2 * numerator + denominator) // (2 * denominator))


AFTER: Mapping[Parameter, Callable[[Parameters], None]] = {
    Parameter.RELEASE_TIMEOUT: Parameters.drop_short_timeout,
    Parameter.VOLTAGE_SETPOINT: lambda values: values.to_percent(Quantity.VOLTAGE),
    Parameter.CURRENT_SETPOINT: lambda values: values.to_percent(Quantity.CURRENT),
    Parameter.SETPOINT_PERCENT: Parameters.from_percent,
    Parameter.VOLTAGE_MINIMUM: lambda values: values.pull_inside(Parameter.VOLTAGE_SETPOINT),
    Parameter.VOLTAGE_MAXIMUM: lambda values: values.lower(Quantity.VOLTAGE),
    Parameter.CURRENT_MINIMUM: lambda values: values.pull_inside(Parameter.CURRENT_SETPOINT),
    Parameter.CURRENT_MAXIMUM: lambda values: values.lower(Quantity.CURRENT),
    Parameter.MODE: lambda values: values.to_percent(values.governing),
    Parameter.WEB_WIDTH: Parameters.from_web_width,
    Parameter.WEB_WIDTH_MINIMUM: lambda values: values.pull_inside(Parameter.WEB_WIDTH),
    Parameter.WEB_WIDTH_MAXIMUM: lambda values: values.pull_inside(Parameter.WEB_WIDTH),
    Parameter.CURRENT_WIDTH_FACTOR: Parameters.from_web_width,
    Parameter.VOLTAGE_SETPOINT_DISCHARGING: Parameters.to_percent_discharging,
    Parameter.SETPOINT_PERCENT_DISCHARGING: Parameters.from_percent_discharging,
}
