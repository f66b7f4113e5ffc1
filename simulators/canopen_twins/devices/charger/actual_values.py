"""What the charger shows: hours (2000h), actual values (2001h), inputs (6000h, 6401h)."""

from collections.abc import Callable, Mapping

from canopen_twins.devices.charger.model.charger import Charger
from canopen_twins.devices.charger.model.hours import duration
from canopen_twins.devices.charger.model.messages import Kind
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.sparks import Counter
from canopen_twins.devices.charger.model.types import Quantity
from canopen_twins.slave.object import Address, Object

UNSIGNED8, UNSIGNED16, SIGNED16 = (0, 0xFF), (0, 0xFFFF), (-0x8000, 0x7FFF)
PERCENT = (0, 100)
HOURS = {0x01: "operating", 0x05: "charging", 0x09: "discharging"}  # 2000h
SENSORS = {0x05: "power_stage", 0x06: "inside", 0x07: "cascade", 0x0D: "discharging"}  # 2001h
LIMITER_BIT = {Quantity.VOLTAGE: 1 << 8, Quantity.CURRENT: 1 << 9, Quantity.POWER: 1 << 10}
DISCHARGING_LIMITED = 1 << 8
MILLI, MICRO = 1e3, 1e6  # of a unit
TENTHS = 10

Read = Callable[[], int]


def saturated(value: float, ends: tuple[int, int]) -> int:
    """A whole number that never wraps (A-65)."""
    return max(ends[0], min(ends[1], round(value)))


class ActualValues:
    """Reads a charger, in the units and the lengths of the dictionary."""

    def __init__(self, charger: Charger) -> None:
        self._charger = charger

    @property
    def objects(self) -> Mapping[Address, Object]:
        """All of them, whatever the variant has."""
        records = {
            0x2000: self._hours,
            0x2001: self._supply | self._sensors | self._charging | self._discharging,
            0x2002: self._setpoints,
            0x6000: self._inputs,
            0x6401: self._measured,
        }
        return {
            (index, subindex): Object(read=read)
            for index, record in records.items()
            for subindex, read in record.items()
        }

    @property
    def _hours(self) -> Mapping[int, Read]:
        hours = self._charger.hours

        def read(name: str, part: int) -> Read:
            return lambda: duration(getattr(hours, name))[part]

        return {first + n: read(name, n) for first, name in HOURS.items() for n in range(4)}

    @property
    def _supply(self) -> dict[int, Read]:
        charger = self._charger

        def utilisation() -> float:
            return 100 * charger.supply.power / charger.build.kind.supply_power

        return {
            0x01: lambda: saturated(charger.supply.voltage * MILLI, UNSIGNED16),
            0x02: lambda: saturated(charger.supply.current * MILLI, UNSIGNED16),
            0x03: lambda: saturated(charger.supply.power * TENTHS, UNSIGNED16),
            0x04: lambda: saturated(utilisation(), UNSIGNED8),
        }

    @property
    def _sensors(self) -> dict[int, Read]:
        charger = self._charger

        def read(sensor: str) -> Read:  # whole degrees, as the thresholds are
            return lambda: saturated(charger.heating.at(charger.now)[sensor] // 1, UNSIGNED8)

        return {subindex: read(sensor) for subindex, sensor in SENSORS.items()}

    @property
    def _charging(self) -> dict[int, Read]:
        charging = self._charger.charging

        def read(counter: Counter) -> Read:
            return lambda: charging.sparks.counts[counter]

        return {
            **{counter.value: read(counter) for counter in Counter},
            0x0C: lambda: charging.resistance,
        }

    @property
    def _discharging(self) -> dict[int, Read]:
        charger, stage = self._charger, self._charger.discharging

        def power(connector: int) -> Read:
            return lambda: saturated(stage.now.powers[connector] * MILLI, UNSIGNED16)

        return {
            0x0E: lambda: charger.discharging_active | DISCHARGING_LIMITED * stage.now.limited,
            0x0F: power(0),
            0x10: power(1),
        }

    @property
    def _setpoints(self) -> Mapping[int, Read]:
        """Those parameters that only the charger itself changes."""
        kind, derating = self._charger.build.kind, self._charger.derating
        return {
            0x05: lambda: 1,  # burn-in done, A-67
            0x0A: lambda: saturated(derating.charging, UNSIGNED16),
            0x1F: lambda: kind.current_discharging,
            0x20: lambda: saturated(derating.discharging, UNSIGNED16),
        }

    @property
    def _inputs(self) -> Mapping[int, Read]:
        charger, kind = self._charger, self._charger.build.kind
        output, stage = charger.charging.output, charger.discharging

        def of(maximum: float, value: Callable[[], float]) -> Read:
            return lambda: saturated(100 * value() / maximum, PERCENT)

        return {
            0x01: self._status,
            0x02: of(kind.maximum_voltage, lambda: output.voltage),
            0x03: of(kind.maximum_current, lambda: output.current * MICRO),
            0x04: of(kind.power, lambda: output.power),
            0x05: lambda: charger.charging.pollution,
            0x06: of(kind.current_discharging, lambda: stage.now.current * MICRO),
            0x07: lambda: charger.dirt[0].value,
            0x08: lambda: charger.dirt[1].value,
        }

    def _status(self) -> int:
        charger = self._charger
        charging, discharging = charger.charging_active, charger.discharging_active
        bits = (
            charging or discharging,
            charger.messages.has(Kind.ERROR),
            charger.messages.has(Kind.WARNING),
            charging,
            discharging,
            charger.release.software,
            charger.charging.calibrating,
        )
        return sum(bit << place for place, bit in enumerate(bits))

    @property
    def _measured(self) -> Mapping[int, Read]:
        charger, stage = self._charger, self._charger.discharging
        output = charger.charging.output

        def mode() -> int:
            limiter = LIMITER_BIT[output.limiter] if output.limiter else 0
            return charger.parameters[Parameter.MODE] | limiter

        return {
            0x01: lambda: saturated(output.voltage, UNSIGNED16),
            0x02: lambda: saturated(output.current * MICRO, UNSIGNED16),
            0x03: lambda: saturated(output.power * TENTHS, UNSIGNED16),
            0x04: mode,
            0x05: lambda: saturated(stage.now.voltage, UNSIGNED16),
            0x06: lambda: saturated(stage.now.current * MICRO, UNSIGNED16),
            0x07: lambda: saturated(stage.now.direct_current * MICRO, SIGNED16),
            0x08: lambda: saturated(stage.now.power * TENTHS, UNSIGNED16),
        }
