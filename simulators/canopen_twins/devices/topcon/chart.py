"""What a TopCon shows over time: its output beside the set values, and the state of the stage."""

from collections.abc import Mapping

from canopen_twins.device import Band, Chart, Curve, Mood
from canopen_twins.devices.topcon.model.stage import OutputStage
from canopen_twins.devices.topcon.model.states import StageState

KILO = 1e3
BANDS: Mapping[StageState, Band] = {
    StageState.POWERUP: Band("power-up", Mood.OFF),
    StageState.READY: Band("ready", Mood.WAITING),
    StageState.RUN: Band("run", Mood.ACTIVE),
    StageState.WARN: Band("run with warning", Mood.WARNING),
    StageState.ERROR: Band("error", Mood.ERROR),
}


def chart(stage: OutputStage) -> Chart:
    """Set values (7.3.5-7.3.7) and actual values (7.3.10-7.3.12)."""
    curves = (
        Curve("Voltage", "V", lambda: stage.voltage, lambda: stage.voltage_reference),
        Curve("Current", "A", lambda: stage.current, lambda: stage.current_reference),
        Curve("Power", "kW", lambda: stage.power / KILO, lambda: stage.power_reference / KILO),
    )
    return Chart(curves, lambda: BANDS[stage.state])
