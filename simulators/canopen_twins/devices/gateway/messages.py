"""What the units tell: 2005h (Table 2, 9.5), emergencies, and a look for a service engineer."""

from collections.abc import Mapping, Sequence

from canopen_twins.device.device import BitMessage
from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.errors import CANOPEN_ERRORS, CanopenError
from canopen_twins.devices.gateway.model.system import System
from canopen_twins.slave.emcy import FIELD_LENGTH, Emcy

WORD = (0x2005, 0x00)
TEXTS: Mapping[CanopenError, str] = {
    CanopenError.DC_RESET: "the governor was reset, the gateway was not",
    CanopenError.INIT: "the governor could not initialise its gateway",
    CanopenError.TIME_CTRL: "an RPDO is missing",
    CanopenError.DC_CAN_BUS: "bus error at the governor",
    CanopenError.DC_CAN_COMM: "the governor lost telegrams, or its gateway",
    CanopenError.GW_RESET: "the gateway was reset, the governor was not",
    CanopenError.HEARTBEAT: "the partner's heartbeat is missing",
    CanopenError.GW_CAN_BUS_1: "error of the bus to the governor",
    CanopenError.GW_CAN_COMM_1: "the gateway lost telegrams, or its governor",
    CanopenError.GW_CAN_BUS_2: "error of the CANopen bus",
    CanopenError.GW_CAN_COMM_2: "a CANopen buffer has overflowed",
}
MESSAGES: Mapping[str, BitMessage] = {
    str(number): BitMessage(TEXTS[error], WORD, error.bit_length() - 1)
    for number, error in CANOPEN_ERRORS.items()
}


HEARTBEAT, COMMUNICATION, VOLTAGE, SOFTWARE = 0x8130, 0x8100, 0x3100, 0x6100
GENERIC = 1  # bit of 0x1001
SOFTWARE_ERRORS = errors.bits(range(errors.PARAM_STORE, errors.INTERN + 1)) & ~errors.bit(
    errors.VOLTAGE
)


def emergencies(system: System, node_id: int) -> Sequence[Emcy]:
    """One for each kind of trouble; every one of them tells 2005h as it is.

    None if a TPDO has their identifier.
    """
    if 0x80 + node_id in _sent(system):
        return ()
    word, present = system.value(0x2005, 0), system.gateway.memory.present
    content = word.to_bytes(FIELD_LENGTH, "little")
    found = {
        HEARTBEAT if word & CanopenError.HEARTBEAT else COMMUNICATION: word,
        VOLTAGE: present & errors.bit(errors.VOLTAGE),
        SOFTWARE: present & SOFTWARE_ERRORS,
    }
    register = system.error_register | GENERIC  # before 3074 has followed, too
    return tuple(
        Emcy(code, register, content, LABELS[code]) for code, bits in found.items() if bits
    )


def _sent(system: System) -> list[int]:
    known = system.dictionary
    return [pdo.identifier for pdo in known.tpdos.values()] if known else []


LABELS = {
    HEARTBEAT: "heartbeat of the partner",
    COMMUNICATION: "CANopen or HEINZMANN CAN",
    VOLTAGE: "supply voltage",
    SOFTWARE: "control unit",
}


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
        "generator breaker": "closed" if engine.connected else "open",
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
    found |= {number for number, error in CANOPEN_ERRORS.items() if word & error}
    told = f", errors {', '.join(map(str, sorted(found)))}" if found else ", no errors"
    lives = f"governor {system.governor.life.value}, gateway {system.gateway.life.value}"
    return f"its CANopen state is {system.state.value}: {lives}{told}"
