"""A look at both units and the engine, as a service engineer and an operator see them."""

from collections.abc import Mapping

from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.canopen_errors import NUMBERS
from canopen_twins.devices.gateway.model.system import System


def report(system: System) -> Mapping[str, object]:
    """What is of interest, in engineering units."""
    engine = system.governor.engine
    return {
        "state": system.state.value,
        "2005h": f"{system.value(0x2005, 0):04X}h",
        "governor": system.governor.life.value,
        "gateway": system.gateway.life.value,
        "errors of the governor": list(errors.numbers(system.governor.memory.present)),
        "errors of the gateway": list(errors.numbers(system.gateway.memory.present)),
        "speed [rpm]": round(engine.speed, 1),
        "actuator [%]": round(100 * engine.position, 1),
        "load [kW]": round(engine.power / 1e3, 1),
        "oil pressure [bar]": round(engine.oil_pressure, 2),
        "charge air [degC]": round(engine.charge_air, 1),
    }


def silence(system: System) -> str:
    """Why the gateway does not communicate; empty if it does (3, 9.5)."""
    if system.listening:
        return ""
    units, word = (system.governor, system.gateway), system.value(0x2005, 0)
    found = {number for unit in units for number in errors.numbers(unit.memory.present)}
    found |= {number for number, error in NUMBERS.items() if word & error}
    told = f", errors {', '.join(map(str, sorted(found)))}" if found else ", no errors"
    lives = f"governor {system.governor.life.value}, gateway {system.gateway.life.value}"
    return f"its CANopen state is {system.state.value}: {lives}{told}"
