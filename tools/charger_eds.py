"""The EDS files of the charger, written from the table of its objects: one per type and variant.

`python -m tools.charger_eds` brings the files of od/ up to date.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path

from canopen_twins.devices.charger.model.types import TYPES, Build, Type, Variant
from canopen_twins.devices.charger.object_table import Row, file_name, filled, rows_of

OD = Path(__file__).parent.parent / "od"
OBJECT_TYPES = {"VAR": 0x7, "ARRAY": 0x8, "RECORD": 0x9}
DATA_TYPES = {
    "INTEGER16": 0x0003,
    "UNSIGNED8": 0x0005,
    "UNSIGNED16": 0x0006,
    "UNSIGNED32": 0x0007,
    "VISIBLE_STRING": 0x0009,
}
MANDATORY = ("1000", "1001", "1018")
HEAD = """\
[FileInfo]
FileName={file}
FileVersion=1
FileRevision=0
EDSVersion=4.0
Description=Written by canopen-twins from the protocol description, not the maker's PC_xx.eds
CreationTime=12:00PM
CreationDate=01-01-2026
CreatedBy=canopen-twins
ModificationTime=12:00PM
ModificationDate=01-01-2026
ModifiedBy=canopen-twins

[DeviceInfo]
VendorName=Eltex-Elektrostatik-GmbH
VendorNumber={vendor}
ProductName=POWER CHARGER {product}
ProductNumber={number}
RevisionNumber={revision}
OrderCode=
BaudRate_10=1
BaudRate_20=0
BaudRate_50=1
BaudRate_125=1
BaudRate_250=1
BaudRate_500=1
BaudRate_800=1
BaudRate_1000=1
SimpleBootUpMaster=0
SimpleBootUpSlave=1
Granularity=0
DynamicChannelsSupported=0
GroupMessaging=0
NrOfRXPDO={receive}
NrOfTXPDO={transmit}
LSS_Supported=1

[DummyUsage]
Dummy0001=0
Dummy0002=0
Dummy0003=0
Dummy0004=0
Dummy0005=0
Dummy0006=0
Dummy0007=0

[Comments]
Lines=3
Line1=Names, types, access and limits are those of the protocol description of the POWER CHARGER.
Line2=What depends on the type (voltages, currents) or is not printed there is assumed.
Line3=Limits that are other entries are not given here; the device checks them at the write.
"""


def text(build: Build) -> str:
    """The EDS of a charger."""
    rows = rows_of(build)
    return "\n".join([_head(build, rows), *_lists(rows), *_objects(build.kind, rows)])


def _head(build: Build, rows: Sequence[Row]) -> str:
    identity = {row.sub: row.default for row in rows if row.index == "1018"}
    objects = [row.index for row in rows if row.object]
    return HEAD.format(
        file=file_name(build),
        vendor=identity["01"],
        product="/".join(filter(None, [build.kind.name, build.entries_of.value])),
        number=identity["02"],
        revision=identity["03"],
        receive=sum(index.startswith("14") for index in objects),
        transmit=sum(index.startswith("18") for index in objects),
    )


def _lists(rows: Sequence[Row]) -> Iterator[str]:
    lists: dict[str, list[str]] = {
        "MandatoryObjects": [],
        "OptionalObjects": [],
        "ManufacturerObjects": [],
    }
    for index in (row.index for row in rows if row.object):
        manufacturer = "2000" <= index < "6000"
        optional = "ManufacturerObjects" if manufacturer else "OptionalObjects"
        lists["MandatoryObjects" if index in MANDATORY else optional].append(index)
    for name, indices in lists.items():
        numbered = {str(number): f"0x{index}" for number, index in enumerate(indices, start=1)}
        yield _section(name, {"SupportedObjects": str(len(indices)), **numbered})


def _objects(kind: Type, rows: Sequence[Row]) -> Iterator[str]:
    for index, group in groupby(rows, key=lambda row: row.index):
        head, *entries = group
        if head.type:
            yield _section(index, _entry(head, kind))
            continue
        about = {"ParameterName": head.name, "ObjectType": f"0x{OBJECT_TYPES[head.object]:X}"}
        yield _section(index, {**about, "SubNumber": str(len(entries))})
        for entry in entries:
            yield _section(f"{index}sub{int(entry.sub, 16):X}", _entry(entry, kind))


def _entry(row: Row, kind: Type) -> dict[str, str]:
    keys = {
        "ParameterName": row.name,
        "ObjectType": "0x7",
        "DataType": f"0x{DATA_TYPES[row.type]:04X}",
        "AccessType": row.access,
        "DefaultValue": row.default,
        "LowLimit": "" if _refers(row.low) else row.low,
        "HighLimit": "" if _refers(row.high) else row.high,
        "PDOMapping": row.pdo,
    }
    return {key: filled(value, kind) for key, value in keys.items() if value}


def _refers(limit: str) -> bool:
    """Whether a limit is another entry, as in `2002:0C`."""
    return ":" in limit


def _section(name: str, keys: Mapping[str, str]) -> str:
    return "\n".join([f"[{name}]", *(f"{key}={value}" for key, value in keys.items()), ""])


def write_all(folder: Path) -> None:
    """Write the file of every type and variant."""
    for kind in TYPES.values():
        for build in (Build(kind, variant) for variant in Variant):
            path = folder / file_name(build)
            path.write_text(text(build), encoding="ascii", newline="\n")


if __name__ == "__main__":
    write_all(OD)
