"""The output stage of a TopCon as a pure model: engineering units, `step(dt)`, no CAN."""

from simulators.devices.topcon.model.load_text import parse_load
from simulators.devices.topcon.model.loads import (
    Battery,
    CurrentSink,
    Inductor,
    Load,
    Open,
    PowerSink,
    Resistor,
    Short,
)
from simulators.devices.topcon.model.modes import Mode, State
from simulators.devices.topcon.model.stage import OutputStage
from simulators.devices.topcon.model.unit import Connection, UnitType

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
    "State",
    "UnitType",
    "parse_load",
]
