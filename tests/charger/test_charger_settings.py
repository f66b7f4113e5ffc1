import pytest
from canopen.objectdictionary.datatypes import INTEGER16, UNSIGNED8, UNSIGNED16, UNSIGNED32
from charger_files import entries, load

from canopen_twins.devices.charger.model.types import PCMT, PCSC, PCTL, TYPES


@pytest.fixture(scope="module")
def od():
    return load()


@pytest.mark.spec("C-046")
def test_the_numbers_of_elements_are_the_printed_ones_gaps_and_all(od):
    printed = {0x2000: 0x0C, 0x2001: 0x10, 0x2002: 0x2A, 0x2003: 5, 0x6000: 8, 0x6200: 1, 0x6401: 8}
    assert {index: od[index][0].default for index in printed} == printed
    assert {0x23, 0x24}.isdisjoint(od[0x2002].subindices)
    assert {3, 4, 5}.isdisjoint(od[0x2003].subindices)


@pytest.mark.spec("C-022", "C-096", "C-118", "C-119", "C-131", "C-153", "C-157", "C-161", "C-166")
@pytest.mark.spec("C-170", "C-171", "C-174", "C-176", "C-179", "C-196", "C-199", "C-201")
@pytest.mark.parametrize(
    ("sub", "default", "low", "high"),
    [
        (0x01, 500, 100, 60000),
        (0x02, 4, 0, 31),
        (0x03, 0, 0, 5),
        (0x04, 0, 0, 60000),
        (0x06, 99, 1, 127),
        (0x07, 4, 0, 8),
        (0x0B, 5, 0, 100),
        (0x11, 500, 100, 10000),
        (0x15, 1000, 100, 5000),
        (0x16, 40, 25, 40),
        (0x17, 25, 10, 25),
        (0x18, 10, 0, 1000),
        (0x19, 0, 0, 2),
        (0x1A, 0, 0, 0xFFFFFFFF),
        (0x1B, 1, 0, 1),
        (0x1C, 0, 0, 1),
        (0x1D, 0, 0, 1),
        (0x21, 100, 0, 100),
        (0x22, 0, 0, 1),
        (0x25, 0, 0, 100),
        (0x26, 0, 0, 8),
        (0x27, 1, 0, 1),
        (0x28, 0, 0, 2),
        (0x29, 0, 0, 1000),
        (0x2A, 0, 0, 1000),
    ],
)
def test_factory_settings_and_constant_limits(od, sub, default, low, high):
    entry = od[0x2002][sub]
    assert (entry.default, entry.min, entry.max) == (default, low, high)


@pytest.mark.spec("C-150", "C-151", "C-154", "C-156", "C-195")
@pytest.mark.parametrize("kind", TYPES.values(), ids=lambda kind: kind.name)
def test_settings_and_limits_that_belong_to_the_type(kind):
    parameters = load(kind)[0x2002]
    told = {
        sub: (parameters[sub].default, parameters[sub].min, parameters[sub].max)
        for sub in (0x08, 0x09, 0x0C, 0x0D, 0x0E, 0x0F, 0x10, 0x1E)
    }
    assert told == {
        0x08: (kind.minimum_voltage, None, None),
        0x09: (kind.maximum_current, None, None),
        0x0C: (kind.minimum_voltage, kind.minimum_voltage, None),
        0x0D: (kind.maximum_voltage, None, kind.maximum_voltage),
        0x0E: (kind.minimum_current, kind.minimum_current, None),
        0x0F: (kind.maximum_current, None, kind.maximum_current),
        0x10: (kind.mode, kind.lowest_mode, kind.highest_mode),
        0x1E: (5000, 1000, 5000),
    }


@pytest.mark.spec("C-042", "C-043")
def test_the_clear_objects_take_the_numbers_there_are(od):
    errors, warnings = od[0x2003][1], od[0x2003][2]
    assert (errors.access_type, errors.min, errors.max) == ("wo", 1, 0x50)
    assert (warnings.access_type, warnings.min, warnings.max) == ("wo", 1, 0x60)


@pytest.mark.spec("C-166", "C-199", "C-200")
@pytest.mark.parametrize(
    ("address", "data_type"),
    [
        ((0x2002, 0x03), UNSIGNED16),
        ((0x2002, 0x29), UNSIGNED16),
        ((0x2002, 0x2A), UNSIGNED16),
        ((0x2001, 0x0E), UNSIGNED16),
        ((0x2001, 0x0C), UNSIGNED32),
        ((0x6401, 0x02), UNSIGNED16),
        ((0x6401, 0x03), UNSIGNED16),
        ((0x6401, 0x07), INTEGER16),
        ((0x6200, 0x01), UNSIGNED8),
    ],
)
def test_types_where_the_manual_contradicts_itself(od, address, data_type):
    assert entries(od)[address].data_type == data_type


@pytest.mark.spec("C-156")
@pytest.mark.parametrize(("kind", "modes"), [(PCSC, (3, 4)), (PCMT, (3, 4)), (PCTL, (5, 7))])
def test_a_type_refuses_the_modes_of_the_others(kind, modes):
    entry = load(kind)[0x2002][0x10]
    assert (entry.min, entry.max) == modes
