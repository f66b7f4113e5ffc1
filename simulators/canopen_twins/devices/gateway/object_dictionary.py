"""What the communication of the gateway leaves of CiA 301: Table 3 to the letter, 16 ms steps."""

from collections.abc import Mapping
from functools import partial
from typing import cast

from canopen import ObjectDictionary
from canopen.objectdictionary import ODArray, ODVariable
from canopen.objectdictionary.datatypes import UNSIGNED16, UNSIGNED32

from canopen_twins.devices.gateway.model.configuration import (
    DIGITAL_OUTPUT,
    HEARTBEAT_LIMIT,
    HEARTBEAT_PERIOD,
    PARTNER_NODE,
    Dictionary,
    Pdo,
)
from canopen_twins.devices.gateway.model.desk import SERIAL, measured
from canopen_twins.devices.gateway.model.gateway import Gateway
from canopen_twins.devices.gateway.model.parameters import Store
from canopen_twins.devices.gateway.model.system import System
from canopen_twins.devices.gateway.model.timing import GATEWAY_CYCLE, heartbeat_cycles
from canopen_twins.slave.object import Object
from canopen_twins.slave.profile import Profile

MICROSECOND = 1e-6  # s


def heartbeat_period(milliseconds: int) -> float:
    """Seconds between two heartbeats: whole main cycles (7.2.3)."""
    return heartbeat_cycles(milliseconds) * GATEWAY_CYCLE * MICROSECOND


PROFILE = Profile(
    segmented=False,
    literal_commands=True,
    length_before_access=True,
    heartbeat_period=heartbeat_period,
    rpdo_emcy=False,
)


MEASURED = {  # 5.1: objects with entries of their own
    DIGITAL_OUTPUT: "Engine State",
    0x2001: "Unsigned Analog Output",
    0x2002: "Signed Analog Output",
    0x2003: "Digital Input",
    0x2004: "Analog Input",
}


def fill(od: ObjectDictionary, known: Dictionary) -> None:
    """Create what the init telegrams create: mappings, their objects, valid identifiers (A-02)."""
    for number, pdo in known.rpdos.items():
        _activate(od, 0x1400 + number - 1, 0x1600 + number - 1, pdo)
    for number, pdo in known.tpdos.items():
        _activate(od, 0x1800 + number - 1, 0x1A00 + number - 1, pdo)
    for index, name in MEASURED.items():
        record, subs = _record(od, index), known.subs(index)
        for sub in (sub for sub in subs if sub not in record.subindices):
            title = name if index == DIGITAL_OUTPUT else f"{name} {sub}"
            record.add_member(_variable(title, index, sub, UNSIGNED16))
        _set(od, index, 0, max(subs, default=0))


def _activate(od: ObjectDictionary, record: int, mapping: int, pdo: Pdo) -> None:
    _set(od, record, 1, pdo.identifier)
    _set(od, mapping, 0, len(pdo.entries))
    for place, entry in enumerate(pdo.entries, start=1):
        variable = _variable(f"Mapping Entry {place}", mapping, place, UNSIGNED32)
        variable.value = entry.mapping
        _record(od, mapping).add_member(variable)


def identify(od: ObjectDictionary, settings: Store, unit: Gateway) -> None:
    """Show the parameters that objects of the communication area stand for (A-06)."""
    partner, limit = settings[PARTNER_NODE], settings[HEARTBEAT_LIMIT]
    _set(od, 0x1016, 1, partner << 16 | limit if partner and limit else 0)
    _set(od, 0x1017, 0, settings[HEARTBEAT_PERIOD])
    _set(od, 0x1018, 3, 0)
    date, number = (int(measured(unit, part)) for part in SERIAL)
    _set(od, 0x1018, 4, date << 16 | number)


def objects(system: System) -> Mapping[tuple[int, int], Object]:
    """The entries that live in the model: 2000h to 2005h."""
    known = system.dictionary or system.planned
    entries = [(0x2005, 0), *((index, sub) for index in MEASURED for sub in known.subs(index))]
    return {entry: Object(read=partial(system.value, *entry)) for entry in entries}


def _variable(name: str, index: int, sub: int, kind: int) -> ODVariable:
    variable = ODVariable(name, index, sub)
    variable.data_type, variable.access_type = kind, "ro"
    variable.pdo_mappable = index in MEASURED
    return variable


def _record(od: ObjectDictionary, index: int) -> ODArray:
    return cast(ODArray, od[index])  # what the manual prints as one


def _set(od: ObjectDictionary, index: int, sub: int, value: int) -> None:
    item = od[index]
    variable = item if isinstance(item, ODVariable) else item.subindices[sub]
    variable.value = value
