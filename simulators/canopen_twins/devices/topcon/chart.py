"""What a TopCon shows over time: its output beside the set values, and the state of the stage."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from canopen_twins.device.chart import Band, Chart, Curve, Mood
from canopen_twins.devices.topcon.model.states import StageState

if TYPE_CHECKING:
    from canopen_twins.devices.topcon import Device


KILO = 1e3

BANDS: Mapping[StageState, Band] = {
    StageState.POWERUP: Band("power-up", Mood.OFF),
    StageState.READY: Band("ready", Mood.WAITING),
    StageState.RUN: Band("run", Mood.ACTIVE),
    StageState.WARN: Band("run with warning", Mood.WARNING),
    StageState.ERROR: Band("error", Mood.ERROR),
}


def chart(device: Device) -> Chart:
    """Set values (7.3.5-7.3.7) and actual values (7.3.10-7.3.12); power-on makes a new stage."""
    curves = (
        Curve("Voltage", "V", lambda: device.stage.voltage, lambda: device.stage.voltage_reference),
        Curve("Current", "A", lambda: device.stage.current, lambda: device.stage.current_reference),
        Curve(
            "Power",
            "kW",
            lambda: device.stage.power / KILO,
            lambda: device.stage.power_reference / KILO,
        ),
    )
    return Chart(curves, lambda: BANDS[device.stage.state])
