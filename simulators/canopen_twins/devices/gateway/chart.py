"""What the governor's engine shows over time, and what the governor does with it."""

from collections.abc import Mapping

from canopen_twins.device.chart import Band, Chart, Curve, Mood
from canopen_twins.devices.gateway.model.engine import Engine
from canopen_twins.devices.gateway.model.errors import OVERSPEED, STOPPING
from canopen_twins.devices.gateway.model.speed_governor import Mode
from canopen_twins.devices.gateway.units import Units

KILO, PERCENT = 1e3, 100

BANDS: Mapping[Mode, Band] = {
    Mode.STOPPED: Band("standing", Mood.OFF),
    Mode.CRANKING: Band("cranking", Mood.WAITING),
    Mode.RESTING: Band("between two attempts to start", Mood.WAITING),
    Mode.RUNNING: Band("running", Mood.ACTIVE),
    Mode.STOPPING: Band("running down", Mood.WARNING),
}
WITHOUT_GOVERNOR = Band("no governor", Mood.OFF)
OVERSPEED_STOP = Band("overspeed stop", Mood.ERROR)
STOP = Band("stopped by an error", Mood.ERROR)


def chart(units: Units) -> Chart:
    """What is wanted of the engine, and what it does; power-on makes a new one."""

    def engine() -> Engine:
        return units.system.governor.engine

    curves = (
        Curve("Speed", "rpm", lambda: engine().speed, lambda: _setpoint(units)),
        Curve("Load", "kW", lambda: engine().power / KILO, lambda: engine().load / KILO),
        Curve(
            "Actuator", "%", lambda: engine().position * PERCENT, lambda: engine().fuel * PERCENT
        ),
    )
    return Chart(curves, lambda: _band(units))


def _band(units: Units) -> Band:
    governor = units.system.governor.programme
    if governor is None:
        return WITHOUT_GOVERNOR
    memory = governor.unit.memory
    if memory.has(OVERSPEED):
        return OVERSPEED_STOP
    stopped = any(memory.has(number) for number in STOPPING)
    return STOP if stopped else BANDS[governor.control.speed.mode]


def _setpoint(units: Units) -> float | None:
    """On its ramp; nothing is governed before the engine runs."""
    governor = units.system.governor.programme
    if governor is None or governor.control.speed.mode is not Mode.RUNNING:
        return None
    return governor.control.speed.setpoint
