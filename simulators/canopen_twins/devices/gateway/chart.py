"""What the governor's engine shows over time, and what the governor does with it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from canopen_twins.device.chart import Band, Chart, Curve, Mood
from canopen_twins.devices.gateway.model.engine import Mode

if TYPE_CHECKING:
    from canopen_twins.devices.gateway import Device


KILO, PERCENT = 1e3, 100

BANDS: Mapping[Mode, Band] = {
    Mode.STOPPED: Band("standing", Mood.OFF),
    Mode.CRANKING: Band("cranking", Mood.WAITING),
    Mode.RUNNING: Band("running", Mood.ACTIVE),
    Mode.STOPPING: Band("running down", Mood.WARNING),
}
WITHOUT_GOVERNOR = Band("no governor", Mood.OFF)
OVERSPEED = Band("overspeed stop", Mood.ERROR)


def chart(device: Device) -> Chart:
    """What is wanted of the engine, and what it does; power-on makes a new one."""
    curves = (
        Curve("Speed", "rpm", lambda: device.system.governor.engine.speed, lambda: _speed(device)),
        Curve(
            "Load",
            "kW",
            lambda: device.system.governor.engine.power / KILO,
            lambda: device.system.governor.engine.load / KILO,
        ),
        Curve(
            "Actuator",
            "%",
            lambda: device.system.governor.engine.position * PERCENT,
            lambda: device.system.governor.engine.fuel * PERCENT,
        ),
    )
    return Chart(curves, lambda: _band(device))


def _band(device: Device) -> Band:
    governor = device.system.governor.programme
    if governor is None:
        return WITHOUT_GOVERNOR
    return OVERSPEED if governor.tripped else BANDS[governor.control.speed.mode]


def _speed(device: Device) -> float | None:
    """On its ramp; nothing is governed before the engine runs."""
    governor = device.system.governor.programme
    if governor is None or governor.control.speed.mode is not Mode.RUNNING:
        return None
    return governor.control.speed.setpoint
