import csv
from importlib import import_module
from pathlib import Path

import pytest
from canopen import import_od
from canopen.objectdictionary import ODVariable

from canopen_twins import Bench, devices
from canopen_twins.devices.charger.messages import catalogue
from canopen_twins.devices.gateway.messages import LABELS
from canopen_twins.devices.topcon.messages import table
from canopen_twins.diagnosis.sections import sections
from canopen_twins.diagnosis.why import Sections
from canopen_twins.files.shipped import od_file

OD = Path(__file__).parents[2] / "od"
EDS_FILES = sorted(path.name for path in OD.glob("*.eds"))
TABLES = sorted(OD.glob("*_sections.csv"))
SERVICES = ("nmt", "states", "sdo", "emcy", "heartbeat", "pdo", "silence")
EMCY_CODES = {
    "topcon": {code for code, _ in table()},
    "charger": {message.emcy for message in catalogue("")},
    "gateway": set(LABELS),
}


def shipped():
    """The devices of this project; those of others may have no table."""
    ours = devices.__name__
    return [name for name in devices.names() if devices.find(name).__module__.startswith(ours)]


def addresses(od):
    for item in od.values():
        subs = {0: item} if isinstance(item, ODVariable) else item.subindices
        yield from ((item.index, sub) for sub in subs if item.index >= 0x1000)


@pytest.mark.parametrize("eds", EDS_FILES)
def test_every_object_of_every_eds_has_a_source(eds):
    with od_file(eds) as path:
        od = import_od(str(path), 1)
    missing = [address for address in addresses(od) if not sections(eds).object(address)]
    assert missing == []


@pytest.mark.parametrize("device", shipped())
def test_every_object_of_the_dictionary_in_force_has_a_source(device):
    bench = Bench(device)
    bench.run(1.0)
    entries = bench.twin.node.slave.entries
    told = sections(bench.twin.node.device.eds)
    assert [(i, s) for i, subs in entries.items() for s in subs if not told.object((i, s))] == []


@pytest.mark.parametrize("device", shipped())
def test_every_service_and_every_emergency_has_a_source(device):
    told = sections(devices.create(device).eds)
    assert [name for name in SERVICES if not told.service(name)] == []
    assert [hex(code) for code in EMCY_CODES[device] if not told.emcy(code)] == []


@pytest.mark.parametrize("table", TABLES, ids=lambda path: path.stem)
def test_a_table_is_about_nothing_that_is_not_there(table):
    device = table.stem.removesuffix("_sections")
    files = [eds for eds in EDS_FILES if eds.startswith(device)]
    known = set()
    for eds in files:
        known |= {index for index, _ in addresses(import_od(str(OD / eds), 1))}
    with table.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["what"] == "object":
                first, _, last = row["of"].partition(":")[0].partition("-")
                named = range(int(first, 16), int(last or first, 16) + 1)
                assert [hex(index) for index in named if index not in known] == []
            elif row["what"] == "emcy" and row["of"] != "any":
                assert int(row["of"], 16) in EMCY_CODES[device]


@pytest.mark.spec("T-052", "T-053", "T-055", "T-190", "T-191")
@pytest.mark.parametrize(
    ("code", "table"), [(0, 64), (0x2300, 67), (0x3300, 70), (0x8200, 82), (0xFF00, 85)]
)
def test_the_tables_of_the_topcon_are_those_of_its_manual(code, table):
    assert sections("topcon.eds").emcy(code) == f"manual 8, Tab. {table}"


def test_the_longest_name_that_fits_wins(tmp_path):
    head = "what,of,source\n"
    eds = str(tmp_path / "my_fan_b.eds")
    (tmp_path / "my_sections.csv").write_text(f"{head}object,2000,one\n")
    assert sections(eds).object((0x2000, 0)) == "one"
    (tmp_path / "my_fan_sections.csv").write_text(f"{head}object,2000,two\n")
    sections.cache_clear()
    assert sections(eds).object((0x2000, 0)) == "two"


def test_an_entry_may_have_a_section_of_its_own():
    told = Sections(
        [
            {"what": "object", "of": "2000", "source": "all"},
            {"what": "object", "of": "2000:02-03", "source": "some"},
        ]
    )
    assert [told.object((0x2000, sub)) for sub in range(5)] == ["all", "all", "some", "some", "all"]
    assert told.object((0x2001, 0)) == told.service("sdo") == told.emcy(0x1000) == ""


@pytest.mark.parametrize(
    "rows",
    [
        [("objekt", "2000")],
        [("object", "2000-2003"), ("object", "2001")],
        [("emcy", "any"), ("emcy", "any")],
        [("emcy", "code")],
    ],
)
def test_a_table_that_cannot_be_meant_is_a_mistake(rows):
    with pytest.raises(ValueError, match=r"."):
        Sections([{"what": what, "of": of, "source": "x"} for what, of in rows])


def test_a_device_without_a_table_is_explained_without_sections(bench, reasons):
    assert sections(bench.twin.node.device.eds).object((0x1017, 0)) == ""
    assert reasons(bench, "605#4012300000000000") == [
        "605#4012300000000000 refused: no such object, 0x3012:00"
    ]
    assert reasons(bench, "000#0205", "605#4000100000000000")[-1] == (
        "605#4000100000000000 not answered: the node was stopped, without SDO"
    )


def test_a_device_of_another_package_brings_its_own(monkeypatch):
    examples = Path(__file__).parents[2] / "docs" / "examples" / "canopen-fan"
    monkeypatch.syspath_prepend(str(examples))
    fan = import_module("canopen_fan").Fan()
    with od_file(fan.eds) as path:
        od = import_od(str(path), 1)
    assert [a for a in addresses(od) if not sections(fan.eds).object(a)] == []
    assert sections(fan.eds).object((0x2000, 0)) == "data sheet, 3"
