"""Digital twins of CANopen slaves: the dictionaries and behaviour of real devices.

What is named here is all that tests, programs and authors of devices need; it is imported when it
is asked for, as pytest loads our plugin in runs that need none of it.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from canopen_twins.errors import UserError

if TYPE_CHECKING:
    from canopen_twins.bench.bench import Bench
    from canopen_twins.bench.simulated_time import SimulatedTimeError, simulated_time
    from canopen_twins.bench.twin import Twin
    from canopen_twins.device import (
        Abort,
        Address,
        Band,
        BitMessage,
        Chart,
        Curve,
        Device,
        Emcy,
        EmcyMessage,
        Farewell,
        Fault,
        Memory,
        Message,
        Mood,
        NodeSettings,
        Object,
        Parameter,
        Profile,
        Rejected,
        Rpdo,
        Service,
        Slave,
        State,
        Tpdo,
        Value,
        Weather,
        setting,
    )
    from canopen_twins.live.remote import connect
    from canopen_twins.scenario import Scenario, Verdict
    from canopen_twins.scenario.load import load
    from canopen_twins.scenario.play import play

__all__ = [
    "Abort",
    "Address",
    "Band",
    "Bench",
    "BitMessage",
    "Chart",
    "Curve",
    "Device",
    "Emcy",
    "EmcyMessage",
    "Farewell",
    "Fault",
    "Memory",
    "Message",
    "Mood",
    "NodeSettings",
    "Object",
    "Parameter",
    "Profile",
    "Rejected",
    "Rpdo",
    "Scenario",
    "Service",
    "SimulatedTimeError",
    "Slave",
    "State",
    "Tpdo",
    "Twin",
    "UserError",
    "Value",
    "Verdict",
    "Weather",
    "connect",
    "load",
    "play",
    "setting",
    "simulated_time",
]

_ROOMS = {
    "bench.bench": {"Bench"},
    "bench.simulated_time": {"SimulatedTimeError", "simulated_time"},
    "bench.twin": {"Twin"},
    "live.remote": {"connect"},
    "scenario": {"Scenario", "Verdict", "load", "play"},
}
"""Where a name comes from, if it is none of the API of devices."""


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    room = next((room for room, names in _ROOMS.items() if name in names), "device")
    globals()[name] = value = getattr(import_module(f"{__name__}.{room}"), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
