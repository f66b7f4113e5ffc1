import re
import subprocess
import sys
from configparser import RawConfigParser
from functools import cache
from pathlib import Path

import canopen
import dcf.cli
import pytest
from canopen.objectdictionary import ODArray, ODRecord, ODVariable
from canopen.objectdictionary.datatypes import VISIBLE_STRING

from canopen_twins.slave import dictionary as dictionaries

NODE_ID = 29
EDS_FILES = sorted(Path(__file__).parents[1].glob("*/*.eds"))  # of the devices, and the probe
LISTS = ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects")
RPDO, TPDO = range(0x1400, 0x1600), range(0x1800, 0x1A00)
ENTRY = re.compile(r"([0-9A-F]{4})(?:sub([0-9A-F]+))?")


@pytest.fixture(params=EDS_FILES, ids=lambda path: path.stem)
def eds(request):
    return request.param


@cache
def imported(eds, node_id):
    """What canopen makes of a file; nobody changes it."""
    return canopen.import_od(str(eds), node_id)


@pytest.fixture
def raw(eds):
    parser = RawConfigParser(delimiters="=")
    parser.optionxform = str
    parser.read_string(eds.read_text("ascii"))
    return parser


@pytest.fixture
def dictionary(eds):
    return imported(eds, NODE_ID)


def entries(raw):
    for section in raw.sections():
        if match := ENTRY.fullmatch(section):
            index, subindex = match.groups()
            yield raw[section], int(index, 16), subindex and int(subindex, 16)


def variables(dictionary):
    for item in dictionary.values():
        if isinstance(item, ODVariable):
            yield item
        else:
            yield from item.subindices.values()


def by_address(dictionary):
    return {(variable.index, variable.subindex): variable for variable in variables(dictionary)}


def written(key, text, data_type):
    """What a key of the file says, read without canopen."""
    if key in {"ParameterName", "AccessType"}:
        return text
    if key == "DefaultValue" and data_type == VISIBLE_STRING:
        return text
    return sum(NODE_ID if term == "$NODEID" else int(term, 0) for term in text.split("+"))


def understood(item):
    """The same keys as canopen has taken them."""
    if not isinstance(item, ODVariable):
        kind = {ODArray: 8, ODRecord: 9}[type(item)]
        return {"ParameterName": item.name, "ObjectType": kind, "SubNumber": len(item.subindices)}
    return {
        "ParameterName": item.name,
        "ObjectType": 7,
        "DataType": item.data_type,
        "AccessType": item.access_type,
        "LowLimit": item.min,
        "HighLimit": item.max,
        "DefaultValue": item.default,
        "PDOMapping": item.pdo_mappable,
    }


def test_plain_text_that_every_tool_reads(eds):
    content = eds.read_bytes()
    assert content.isascii()
    assert b"\r" not in content
    assert content.endswith(b"\n")


def test_the_file_says_its_own_name_and_when_it_was_written(eds, raw):
    info = raw["FileInfo"]
    assert info["FileName"] == eds.name
    for event in ("Creation", "Modification"):
        assert re.fullmatch(r"[01]\d-[0-3]\d-\d{4}", info[f"{event}Date"])
        assert re.fullmatch(r"[01]\d:[0-5]\d[AP]M", info[f"{event}Time"])


def test_canopen_loses_no_key_of_any_entry(raw, dictionary):
    for section, index, subindex in entries(raw):
        item = dictionary[index] if subindex is None else dictionary[index].subindices[subindex]
        data_type = getattr(item, "data_type", None)
        said = {key: written(key, text, data_type) for key, text in section.items() if text}
        taken = understood(item)
        assert {key: taken.get(key) for key in said} == said, section.name


def test_canopen_invents_no_entry(raw, dictionary):
    said = {(index, sub or 0) for section, index, sub in entries(raw) if "DataType" in section}
    assert {(index, sub) for index, sub in by_address(dictionary) if index >= 0x1000} == said


def everything(item):
    """What an item of a dictionary has, and all items in it; but not whose it is."""
    if isinstance(item, dict):
        return {key: everything(each) for key, each in item.items()}
    if type(item).__module__ != ODVariable.__module__:
        return item
    known = {key: value for key, value in vars(item).items() if key != "parent"}
    return type(item), everything(known)


@pytest.mark.parametrize("node_id", [1, 29, 127])
def test_a_twin_has_the_dictionary_that_canopen_imports(eds, node_id):
    twins = dictionaries.dictionary(str(eds), node_id)
    known = dict(vars(twins))
    assert known.pop("ambiguous") == {}
    assert everything(known) == everything(vars(imported(eds, node_id)))


def test_every_default_can_be_sent(dictionary):
    for variable in variables(dictionary):
        if variable.default is not None:
            assert variable.decode_raw(variable.encode_raw(variable.default)) == variable.default


@pytest.mark.parametrize("node_id", [1, 29, 127])
def test_dcfchk_finds_nothing_to_say(eds, node_id, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["dcfchk", "-n", str(node_id), str(eds)])
    dcf.cli.main()  # or SystemExit
    assert capsys.readouterr() == ("", "")


def test_dcfgen_makes_a_boot_master_of_them_all_without_a_word(tmp_path):
    lines = ["master: {node_id: 127, heartbeat_consumer: true}"]
    for node_id, eds in enumerate(EDS_FILES, 1):
        can_be_set = imported(eds, NODE_ID)[0x1017].writable
        heartbeat = ", heartbeat_producer: 100" if can_be_set else ""
        lines.append(f"{eds.stem}: {{dcf: {eds}, node_id: {node_id}{heartbeat}}}")
    (tmp_path / "bus.yaml").write_text("\n".join(lines))
    python = [sys.executable, "-W", "ignore:pkg_resources"]
    command = [*python, "-m", "dcfgen.cli", "-r", "-d", tmp_path, tmp_path / "bus.yaml"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")
    master = RawConfigParser()
    master.read(tmp_path / "master.dcf")
    assert int(master["1F81Value"]["NrOfEntries"]) == len(EDS_FILES)


def test_the_lists_name_every_object_once(raw):
    listed = []
    for name in LISTS:
        count = int(raw[name]["SupportedObjects"])
        assert list(raw[name]) == ["SupportedObjects", *map(str, range(1, count + 1))]
        listed += [int(raw[name][str(number)], 0) for number in range(1, count + 1)]
    assert sorted(listed) == sorted(index for _, index, sub in entries(raw) if sub is None)


def test_no_two_objects_share_a_name_nor_two_entries_of_an_object(dictionary):
    assert len(dictionary.names) == len(dictionary.indices)
    for item in dictionary.values():
        if not isinstance(item, ODVariable):
            assert len(item.names) == len(item.subindices), item


def test_the_device_is_the_one_of_its_identity_object(dictionary):
    info = dictionary.device_information
    said = {1: info.vendor_number, 2: info.product_number, 3: info.revision_number}
    identity = {subindex: dictionary[0x1018][subindex].default for subindex in said}
    assert identity[1] is not None
    for subindex, default in identity.items():  # a manual may leave open what the device tells
        assert default in {said[subindex], None}


def test_every_pdo_is_counted_and_has_its_mapping(dictionary):
    info = dictionary.device_information
    for pdos, count in ((RPDO, info.nr_of_RXPDO), (TPDO, info.nr_of_TXPDO)):
        parameters = [index for index in dictionary if index in pdos]
        mappings = [index for index in dictionary if index - 0x200 in pdos]
        assert len(parameters) == count
        assert mappings == [index + 0x200 for index in parameters]


@pytest.mark.parametrize(("pdos", "use"), [(RPDO, "writable"), (TPDO, "readable")])
def test_every_mapped_object_is_there_and_fits(dictionary, pdos, use):
    known = by_address(dictionary)
    for index in (index for index in dictionary if index - 0x200 in pdos):
        count, *slots = (known[at].default for at in sorted(known) if at[0] == index)
        mapped = [entry for entry in slots if entry]
        assert len(mapped) == count
        for entry in mapped:
            target = known[entry >> 16, entry >> 8 & 0xFF]
            assert target.pdo_mappable, target
            assert getattr(target, use), target
            assert len(target) == entry & 0xFF, target
        assert sum(entry & 0xFF for entry in mapped) <= 64


def test_a_process_value_has_no_default(dictionary):
    for variable in variables(dictionary):
        if variable.pdo_mappable and not variable.writable:
            assert variable.default is None, variable
