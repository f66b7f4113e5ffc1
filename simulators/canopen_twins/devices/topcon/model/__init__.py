"""The output stage of a TopCon as a pure model: engineering units, `step(dt)`, no CAN."""

from canopen_twins.devices.topcon.model.loads import (
    Battery,
    CurrentSink,
    Inductor,
    Load,
    Open,
    PowerSink,
    Resistor,
    Short,
    parse_load,
)
from canopen_twins.devices.topcon.model.stage import OutputStage
from canopen_twins.devices.topcon.model.states import Mode, StageState
from canopen_twins.devices.topcon.model.unit import Connection, UnitType

__all__ = [
    "Battery",
    "Connection",
    "CurrentSink",
    "Inductor",
    "Load",
    "Mode",
    "Open",
    "OutputStage",
    "PowerSink",
    "Resistor",
    "Short",
    "StageState",
    "UnitType",
    "parse_load",
]
