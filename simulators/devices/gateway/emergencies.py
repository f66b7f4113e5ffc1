"""Emergencies of the extension `emcy: assumed`; the device itself has none (A-01)."""

from collections.abc import Sequence

from simulators.devices.gateway.model import errors
from simulators.devices.gateway.model.canopen_errors import CanopenError
from simulators.devices.gateway.model.system import System
from simulators.services.emcy import FIELD_LENGTH, Emcy

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
