"""Device configuration files (CiA 306): the dictionary of a device as it is after a boot.

Everything is written as the standard prints it, so that every reader takes it, also one that is
strict: sections in the order of the standard, no key that it does not know, ASCII where the names
of the device are.
"""

import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from canopen import ObjectDictionary
from canopen.objectdictionary import ODArray, ODVariable
from canopen.objectdictionary.datatypes import (
    BOOLEAN,
    DOMAIN,
    FLOAT_TYPES,
    INTEGER_TYPES,
    UNICODE_STRING,
    VISIBLE_STRING,
)

from canopen_twins.bus.clock import Clock
from canopen_twins.device.device import Device
from canopen_twins.device.node import Node, wait_for_boot
from canopen_twins.errors import UserError
from canopen_twins.slave.eds import values
from canopen_twins.slave.eds.head import BIT_RATES
from canopen_twins.slave.eds.reader import HIGHEST_SUB
from canopen_twins.slave.object import TIMES, Entry, Rejected, entries_of
from canopen_twins.slave.slave import Slave

DOMAIN_OBJECT, VAR, ARRAY, RECORD = "0x2", "0x7", "0x8", "0x9"
MANDATORY = (0x1000, 0x1001, 0x1018)
MAKER = range(0x2000, 0x6000)
FILE_INFO = {
    "FileName": "", "FileVersion": "1", "FileRevision": "0", "EDSVersion": "4.0",
    "Description": "", "CreationTime": "12:00AM", "CreationDate": "01-01-2026",
    "CreatedBy": "canopen-twins", "ModificationTime": "12:00AM",
    "ModificationDate": "01-01-2026", "ModifiedBy": "canopen-twins",
}  # fmt: skip
USUAL_RATE = 500_000  # bit/s, of a device of which nobody says any
COMMANDS = (0x1010, 0x1011)  # what they read is no value to write
PLAIN = re.compile(r"-?(?:0x[0-9A-Fa-f]+|0|[1-9][0-9]*)")
"""A number that every reader takes for the same."""

Keys = dict[str, str]


def dcf(device: Device) -> str:
    """The text of the file: the dictionary, and every value that is not its default.

    Raises:
        UserError: the device does not boot with these settings.
    """
    slave = _booted(device)
    od: Any = slave.object_dictionary
    objects = {index: item for index, item in od.indices.items() if index in slave.entries}
    sections = {
        "FileInfo": _file_info(od, Path(device.eds).name),
        "DeviceInfo": _device_info(od, slave),
        "DummyUsage": {f"Dummy{n:04X}": str(int(n in od.indices)) for n in range(1, 8)},
        "Comments": _comments(od),
        "DeviceComissioning": _commissioning(device, slave),
        **_lists(objects),
    }
    for index, item in sorted(objects.items()):
        sections |= _object(index, item, slave)
    return "\n".join(_text(name, keys) for name, keys in sections.items())


def _booted(device: Device) -> Slave:
    node = Node(device, Clock())
    node.power_on()
    if not wait_for_boot([node], node.clock.advance) or node.slave is None:
        raise UserError("with these settings it does not boot")
    return node.slave


def _text(name: str, keys: Keys) -> str:
    return "\n".join([f"[{name}]", *(f"{key}={text}" for key, text in keys.items()), ""])


# what stands before the objects


def _file_info(od: ObjectDictionary, eds: str) -> Keys:
    said = {key.lower(): text for key, text in getattr(od, "__edsFileInfo", {}).items()}
    info = {key: said.get(key.lower()) or text for key, text in FILE_INFO.items()}
    return {**info, "FileName": f"{Path(eds).stem}.dcf", "LastEDS": eds}


def _device_info(od: ObjectDictionary, slave: Slave) -> Keys:
    info: Any = od.device_information
    identity = [
        slave.number(0x1018, sub) if slave.has(0x1018, sub) else number or 0
        for sub, number in enumerate(
            (info.vendor_number, info.product_number, info.revision_number), start=1
        )
    ]
    flags = {
        "SimpleBootUpMaster": info.simple_boot_up_master,
        "SimpleBootUpSlave": info.simple_boot_up_slave,
        "Granularity": info.granularity,
        "DynamicChannelsSupported": info.dynamic_channels_supported,
        "GroupMessaging": info.group_messaging,
        "NrOfRXPDO": info.nr_of_RXPDO,
        "NrOfTXPDO": info.nr_of_TXPDO,
        "LSS_Supported": info.LSS_supported,
    }
    return {
        "VendorName": info.vendor_name or "",
        "VendorNumber": _hexadecimal(identity[0]),
        "ProductName": info.product_name or "",
        "ProductNumber": _hexadecimal(identity[1]),
        "RevisionNumber": _hexadecimal(identity[2]),
        "OrderCode": info.order_code or "",
        **{
            f"BaudRate_{rate}": str(int(rate * 1000 in info.allowed_baudrates))
            for rate in BIT_RATES
        },
        **{key: str(int(number or 0)) for key, number in flags.items()},
    }


def _hexadecimal(number: int) -> str:
    return f"0x{number:08X}"


def _comments(od: ObjectDictionary) -> Keys:
    lines = str(od.comments or "").splitlines()
    numbered = {f"Line{number}": line for number, line in enumerate(lines, 1)}
    return {"Lines": str(len(lines)), **numbered}


def _commissioning(device: Device, slave: Slave) -> Keys:
    possible = slave.object_dictionary.device_information.allowed_baudrates
    usual = USUAL_RATE if USUAL_RATE in possible else max(possible, default=USUAL_RATE)
    keys = {
        "NodeID": str(slave.node_id),
        "NodeName": device.title,
        "Baudrate": str((device.bit_rate or usual) // 1000),
        "NetNumber": "0",
        "NetworkName": "",
        "CANopenManager": "0",
    }
    if slave.has(0x1018, 4):
        keys["LSS_SerialNumber"] = _hexadecimal(slave.number(0x1018, 4))
    return keys


def _lists(objects: Mapping[int, Any]) -> dict[str, Keys]:
    lists: dict[str, list[int]] = {
        "MandatoryObjects": [], "OptionalObjects": [], "ManufacturerObjects": [],
    }  # fmt: skip
    for index in sorted(objects):
        other = "ManufacturerObjects" if index in MAKER else "OptionalObjects"
        lists["MandatoryObjects" if index in MANDATORY else other].append(index)
    return {
        name: {
            "SupportedObjects": str(len(found)),
            **{str(number): f"0x{index:04X}" for number, index in enumerate(found, 1)},
        }
        for name, found in lists.items()
    }


# objects


def _object(index: int, item: Any, slave: Slave) -> Iterator[tuple[str, Keys]]:
    name = f"{index:04X}"
    if isinstance(item, ODVariable):
        yield name, _entry(slave.entry(index, 0), slave.node_id, single=True)
        return
    subs = sorted(entries_of(item))
    yield (
        name,
        {
            "ParameterName": item.name,
            "ObjectType": ARRAY if isinstance(item, ODArray) else RECORD,
            "SubNumber": str(sum(sub <= HIGHEST_SUB for sub in subs)),
        },
    )
    for sub in subs:
        yield f"{name}sub{sub:X}", _entry(slave.entry(index, sub), slave.node_id)


def _entry(entry: Entry, node_id: int, single: bool = False) -> Keys:
    variable: Any = entry.variable
    data_type: int = variable.data_type
    keys = {
        "ParameterName": variable.name,
        "ObjectType": DOMAIN_OBJECT if single and data_type == DOMAIN else VAR,
        "DataType": f"0x{data_type:04X}",
        "AccessType": variable.access_type,
    }
    text, default = _default(variable, node_id)
    if text:
        keys["DefaultValue"] = text
    for key, limit in (("LowLimit", variable.min), ("HighLimit", variable.max)):
        if limit is not None:
            keys[key] = str(limit)
    keys["PDOMapping"] = str(int(variable.pdo_mappable))
    if entry.readable and entry.address[0] not in COMMANDS:
        with suppress(Rejected):  # it has no value to read
            if (value := entry.read()) != (default or bytes(entry.size or 0)):
                keys["ParameterValue"] = _value(entry.unpack(value), value, data_type)
    return keys


def _default(variable: Any, node_id: int) -> tuple[str, bytes]:
    """What the file of the device says, and what that is at this node id; empty if nothing."""
    raw = getattr(variable, "default_raw", None)
    if not raw:
        return "", b""
    try:
        found = values.value(raw, variable.data_type)
    except ValueError:
        return "", b""
    value: Any = found.value
    if found.relative:
        packed = variable.encode_raw(value + node_id)
        return f"$NODEID+0x{value:X}", packed
    packed = value if isinstance(value, bytes) else variable.encode_raw(value)
    if PLAIN.fullmatch(raw) and int(raw, 0) == value:
        return raw, packed
    return _value(value, packed, variable.data_type), packed


def _value(value: Any, packed: bytes, data_type: int) -> str:
    """A value as the standard writes it."""
    if data_type in (VISIBLE_STRING, UNICODE_STRING) and isinstance(value, str):
        return value.rstrip("\0")
    if data_type == BOOLEAN:
        return str(int(value))
    if data_type in FLOAT_TYPES:
        return repr(value)
    if data_type in INTEGER_TYPES:
        return f"0x{value:X}" if value >= 0 else str(value)
    if data_type in TIMES:
        return f"0x{int.from_bytes(packed, 'little'):X}"
    return packed.hex().upper()
