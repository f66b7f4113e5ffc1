import pytest
from canopen.objectdictionary import ODVariable
from charger_files import NODE_ID, entries, load, values

from canopen_twins.devices.charger.model.types import PCSC, TYPES, Build, Variant
from canopen_twins.devices.charger.object_table import file_name, table
from canopen_twins.files.shipped import od_file
from tools.charger_eds import text, write_all

OBJECTS = {  # index: number of entries, as the overview of the manual and its tables have them
    0x1000: 1,
    0x1001: 1,
    0x1003: 2,
    0x1008: 1,
    0x100A: 1,
    0x1010: 2,
    0x1011: 2,
    0x1014: 1,
    0x1017: 1,
    0x1018: 5,
    0x1200: 3,
    0x1400: 3,
    0x1600: 2,
    0x1800: 3,
    0x1801: 3,
    0x1802: 3,
    0x1A00: 9,
    0x1A01: 5,
    0x1A02: 5,
    0x2000: 13,
    0x2001: 17,
    0x2002: 41,
    0x2003: 3,
    0x6000: 9,
    0x6200: 2,
    0x6401: 9,
}
DISCHARGING_HOURS = {(0x2000, sub) for sub in range(0x09, 0x0D)}
ONLY_IN_A = {(0x2001, 0x0D), (0x2001, 0x0E)} | {
    (0x2002, sub) for sub in (0x1E, 0x1F, 0x20, 0x21, 0x22, 0x25, 0x26, 0x27, 0x28)
}
BUILDS = [Build(kind, variant) for kind in TYPES.values() for variant in Variant]


@pytest.fixture(scope="module")
def od():
    return load()


@pytest.mark.parametrize("build", BUILDS, ids=file_name)
def test_the_files_are_what_the_table_says_now(build):
    with od_file(file_name(build)) as path:
        assert path.read_bytes() == text(build).encode("ascii")


def test_one_file_for_every_type_and_variant(tmp_path):
    write_all(tmp_path)
    written = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert written == {file_name(build): text(build).encode("ascii") for build in BUILDS}


def test_26_objects_with_147_entries(od):
    subs = {index: len(getattr(item, "subindices", [0])) for index, item in od.items()}
    assert subs == OBJECTS
    assert (len(subs), sum(subs.values())) == (26, 147)


@pytest.mark.spec("C-190", "C-191", "C-192", "C-193", "C-202")
@pytest.mark.parametrize(
    ("variant", "missing"),
    [
        (Variant.BASE, DISCHARGING_HOURS | ONLY_IN_A),
        (Variant.A, set()),
        (Variant.C, ONLY_IN_A),
    ],
)
@pytest.mark.parametrize("kind", TYPES.values(), ids=lambda kind: kind.name)
def test_a_variant_lacks_what_the_manual_says_it_lacks(od, kind, variant, missing):
    assert entries(od).keys() - entries(load(kind, variant)).keys() == missing


@pytest.mark.spec("C-190")
def test_a_c_that_is_set_like_an_a_has_the_entries_of_an_a():
    assert file_name(Build(PCSC, Variant.C, superset=True)) == file_name(Build(PCSC, Variant.A))
    assert file_name(Build(PCSC, Variant.BASE, superset=True)) == file_name(Build(PCSC))


@pytest.mark.spec("C-111")
@pytest.mark.parametrize("kind", TYPES.values(), ids=lambda kind: kind.name)
def test_the_device_name_is_that_of_the_type(kind):
    assert load(kind)[0x1008].default == kind.name
    assert len(kind.name) == 4


@pytest.mark.spec("C-110", "C-112", "C-113", "C-116")
def test_identity(od):
    assert od[0x1000].default == 0x191
    assert len(od[0x100A].default) == 4
    assert values(od, 0x1018)[:2] == [4, 0x24E]
    assert od[0x1010][0].default == od[0x1011][0].default == 1


@pytest.mark.spec("C-038", "C-070", "C-091", "C-092", "C-093", "C-094")
def test_identifiers_follow_the_node_id(od):
    assert od[0x1014].default == 0x80 + NODE_ID
    assert values(od, 0x1200) == [2, 0x600 + NODE_ID, 0x580 + NODE_ID]
    cob_ids = {0x1400: 0x200, 0x1800: 0x180, 0x1801: 0x280, 0x1802: 0x380}
    for index, cob_id in cob_ids.items():
        assert values(od, index) == [2, cob_id + NODE_ID, 255]


@pytest.mark.spec("C-091", "C-092", "C-093", "C-094")
def test_the_mapping_of_the_pdos(od):
    assert values(od, 0x1600) == [1, 0x62000108]
    assert values(od, 0x1A00) == [8, *(0x60000008 | sub << 8 for sub in range(1, 9))]
    assert values(od, 0x1A01) == [4, *(0x64010010 | sub << 8 for sub in range(1, 5))]
    assert values(od, 0x1A02) == [4, *(0x64010010 | sub << 8 for sub in range(5, 9))]


@pytest.mark.spec("C-095")
def test_nothing_of_a_pdo_can_be_written(od):
    pdos = [variable for (index, _), variable in entries(od).items() if 0x1400 <= index < 0x2000]
    assert {variable.access_type for variable in pdos} == {"ro"}


@pytest.mark.parametrize("build", BUILDS, ids=file_name)
def test_the_file_does_not_pass_for_the_one_of_the_maker(build):
    assert "not the maker's" in text(build).splitlines()[5]


def test_a_master_finds_every_entry_by_its_name(od):
    for (index, sub), variable in entries(od).items():
        item = od[od[index].name]
        found = item if isinstance(item, ODVariable) else item[variable.name]
        assert (found.index, found.subindex) == (index, sub)


def test_no_two_files_describe_the_same(od):
    bodies = {text(build).partition("[MandatoryObjects]")[2] for build in BUILDS}
    assert len(bodies) == len(BUILDS) == 12


def test_the_table_is_sorted_and_has_no_entry_twice():
    addresses = [(int(row.index, 16), int(row.sub or "-1", 16)) for row in table()]
    assert addresses == sorted(set(addresses))
