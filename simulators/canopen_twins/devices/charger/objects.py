"""The application's objects: what the master sets and commands, and what the charger shows."""

from collections.abc import Callable, Mapping
from functools import partial

from canopen_twins.device import Abort, Address, Object, Rejected
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

REFUSALS = {Direction.LOW: Abort.TOO_LOW, Direction.HIGH: Abort.TOO_HIGH}
LOCKED, RELEASED = 0x00, 0x0F  # 6200h:01h
UNSIGNED8, UNSIGNED16, SIGNED16 = (0, 0xFF), (0, 0xFFFF), (-0x8000, 0x7FFF)
PERCENT = (0, 100)
MEASURED = (
    *((0x2001, subindex) for subindex in (0x01, 0x02, 0x03, 0x05, 0x06, 0x07, 0x0D)),
    *((0x6401, subindex) for subindex in (0x01, 0x02, 0x03, 0x05, 0x06, 0x07, 0x08)),
)
"""What has a sensor, and is no percentage of it."""
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


def actual_values(charger: Charger) -> Mapping[Address, Object]:
    """Hours (2000h), actual values (2001h), inputs (6000h, 6401h), whatever the variant has."""
    records = {
        0x2000: _hours(charger),
        0x2001: _supply(charger) | _sensors(charger) | _charging(charger) | _discharging(charger),
        0x2002: _setpoints(charger),
        0x6000: _inputs(charger),
        0x6401: _measured(charger),
    }
    return {
        (index, subindex): Object(read=read)
        for index, record in records.items()
        for subindex, read in record.items()
    }


def _hours(charger: Charger) -> dict[int, Read]:
    def read(count: Callable[[], int], part: int) -> Read:
        return lambda: duration(count())[part]

    hours = charger.hours
    counters = {
        0x01: lambda: hours.operating,
        0x05: lambda: hours.charging,
        0x09: lambda: hours.discharging,
    }
    return {first + n: read(count, n) for first, count in counters.items() for n in range(4)}


def _supply(charger: Charger) -> dict[int, Read]:
    def utilisation() -> float:
        return 100 * charger.supply.power / charger.build.kind.supply_power

    return {
        0x01: lambda: saturated(charger.supply.voltage * MILLI, UNSIGNED16),
        0x02: lambda: saturated(charger.supply.current * MILLI, UNSIGNED16),
        0x03: lambda: saturated(charger.supply.power * TENTHS, UNSIGNED16),
        0x04: lambda: saturated(utilisation(), UNSIGNED8),
    }


def _sensors(charger: Charger) -> dict[int, Read]:
    def read(sensor: str) -> Read:  # whole degrees, as the thresholds are
        return lambda: saturated(charger.heating.at(charger.now)[sensor] // 1, UNSIGNED8)

    return {subindex: read(sensor) for subindex, sensor in SENSORS.items()}


def _charging(charger: Charger) -> dict[int, Read]:
    charging = charger.charging

    def read(counter: Counter) -> Read:
        return lambda: charging.sparks.counts[counter]

    return {
        **{counter.value: read(counter) for counter in Counter},
        0x0C: lambda: charging.resistance,
    }


def _discharging(charger: Charger) -> dict[int, Read]:
    stage = charger.discharging

    def power(connector: int) -> Read:
        return lambda: saturated(stage.now.powers[connector] * MILLI, UNSIGNED16)

    return {
        0x0E: lambda: charger.discharging_active | DISCHARGING_LIMITED * stage.now.limited,
        0x0F: power(0),
        0x10: power(1),
    }


def _setpoints(charger: Charger) -> dict[int, Read]:
    """Those parameters that only the charger itself changes."""
    kind, derating = charger.build.kind, charger.derating
    return {
        0x05: lambda: 1,  # burn-in done, A-67
        0x0A: lambda: saturated(derating.charging, UNSIGNED16),
        0x1F: lambda: kind.current_discharging,
        0x20: lambda: saturated(derating.discharging, UNSIGNED16),
    }


def _inputs(charger: Charger) -> dict[int, Read]:
    kind = charger.build.kind
    output, stage = charger.charging.output, charger.discharging

    def of(maximum: float, value: Callable[[], float]) -> Read:
        return lambda: saturated(100 * value() / maximum, PERCENT)

    return {
        0x01: partial(_status, charger),
        0x02: of(kind.maximum_voltage, lambda: output.voltage),
        0x03: of(kind.maximum_current, lambda: output.current * MICRO),
        0x04: of(kind.power, lambda: output.power),
        0x05: lambda: charger.charging.pollution,
        0x06: of(kind.current_discharging, lambda: stage.now.current * MICRO),
        0x07: lambda: charger.dirt[0].value,
        0x08: lambda: charger.dirt[1].value,
    }


def _status(charger: Charger) -> int:
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


def _measured(charger: Charger) -> dict[int, Read]:
    stage = charger.discharging
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
