"""The application's objects: what the master sets and commands, and what the charger shows."""

from collections.abc import Callable, Mapping
from functools import partial

from canopen_twins.devices.charger.model.charger import Charger
from canopen_twins.devices.charger.model.messages import Severity
from canopen_twins.devices.charger.model.parameters import (
    SHORTEST_TIMEOUT,
    Direction,
    OutOfRange,
    Parameter,
)
from canopen_twins.devices.charger.model.release import ReleaseSource, ReleaseState
from canopen_twins.devices.charger.model.sparks import Counter
from canopen_twins.devices.charger.model.ticks import duration
from canopen_twins.devices.charger.model.types import Quantity
from canopen_twins.slave.object import Abort, Address, Object, Rejected

REFUSALS = {Direction.LOW: Abort.TOO_LOW, Direction.HIGH: Abort.TOO_HIGH}
LOCKED, RELEASED = 0x00, 0x0F  # 6200h:01h
UNSIGNED8, UNSIGNED16, SIGNED16 = (0, 0xFF), (0, 0xFFFF), (-0x8000, 0x7FFF)
PERCENT = (0, 100)
HOURS = {0x01: "operating", 0x05: "charging", 0x09: "discharging"}  # 2000h
SENSORS = {0x05: "power_stage", 0x06: "inside", 0x07: "cascade", 0x0D: "discharging"}  # 2001h
LIMITER_BIT = {Quantity.VOLTAGE: 1 << 8, Quantity.CURRENT: 1 << 9, Quantity.POWER: 1 << 10}
DISCHARGING_LIMITED = 1 << 8
MILLI, MICRO = 1e3, 1e6  # of a unit
TENTHS = 10

Read = Callable[[], int]


def _no_timeout(milliseconds: int) -> str:
    short = 0 < milliseconds < SHORTEST_TIMEOUT
    return f"below {SHORTEST_TIMEOUT} ms it is kept as 0, which is no time-out" if short else ""


OBSTACLES = {Parameter.RELEASE_TIMEOUT: _no_timeout}


class Control:
    """Parameters (2002h), clearing (2003h) and release (6200h): the bus in front of a charger."""

    def __init__(self, charger: Charger) -> None:
        self._charger = charger

    @property
    def objects(self) -> Mapping[Address, Object]:
        """All that the model acts on, whatever the variant has."""
        values = self._charger.parameters
        return {
            **{
                (0x2002, parameter.value): Object(
                    read=partial(values.__getitem__, parameter),
                    write=partial(self._write, parameter),
                    obstacle=OBSTACLES.get(parameter),
                )
                for parameter in Parameter
            },
            (0x2003, 0x01): self._clearing(Severity.ERROR),
            (0x2003, 0x02): self._clearing(Severity.WARNING),
            (0x6200, 0x01): Object(write=self._release, obstacle=self._release_obstacle),
        }

    def _clearing(self, severity: Severity) -> Object:
        def obstacle(number: int) -> str:
            active = self._charger.messages.find(severity, number)
            return "its cause is still there (A-35)" if active else ""

        return Object(write=partial(self._charger.clear, severity), obstacle=obstacle)

    def on_rpdo_refused(self, refusal: Rejected) -> None:
        """A byte in the RPDO that is neither locks; one that is missing is no byte (A-25, A-45)."""
        if refusal.code == Abort.INVALID_VALUE:
            self._charger.revoke(ReleaseSource.CANOPEN)

    def _write(self, parameter: Parameter, value: int) -> None:
        try:
            self._charger.write(parameter, value)
        except OutOfRange as refusal:
            raise Rejected(str(refusal), REFUSALS[refusal.direction]) from refusal

    def _release_obstacle(self, value: int) -> str:
        release = self._charger.release
        if ReleaseSource.CANOPEN not in self._charger.enabled:
            return "0x2002:02 bit 3 does not let CANopen release (A-46)"
        if value == RELEASED and release.state is ReleaseState.FAULT:
            return "an error blocks the release until it is cleared (A-48)"
        if value == RELEASED and not release.closed:
            return "the hardware release is open (A-47)"
        return ""

    def _release(self, value: int) -> None:
        commands = {LOCKED: self._charger.revoke, RELEASED: self._charger.grant}
        if value not in commands:
            raise Rejected(f"{value:#04x} is neither locked (0x00) nor released (0x0f)")
        commands[value](ReleaseSource.CANOPEN)


def saturated(value: float, ends: tuple[int, int]) -> int:
    """A whole number that never wraps (A-65)."""
    return max(ends[0], min(ends[1], round(value)))


class ActualValues:
    """Hours (2000h), actual values (2001h), inputs (6000h, 6401h), in units of the dictionary."""

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
            charger.messages.has(Severity.ERROR),
            charger.messages.has(Severity.WARNING),
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
