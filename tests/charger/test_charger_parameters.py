import pytest

from canopen_twins.devices.charger.model.parameters import LIMITS, Direction, OutOfRange, Parameter
from canopen_twins.devices.charger.model.types import PCMT, PCSC, PCTL, TYPES
from canopen_twins.devices.charger.object_table import factory, table

VOLTAGE = (Parameter.VOLTAGE_SETPOINT, Parameter.VOLTAGE_MINIMUM, Parameter.VOLTAGE_MAXIMUM)
CURRENT = (Parameter.CURRENT_SETPOINT, Parameter.CURRENT_MINIMUM, Parameter.CURRENT_MAXIMUM)
WIDTH = (Parameter.WEB_WIDTH, Parameter.WEB_WIDTH_MINIMUM, Parameter.WEB_WIDTH_MAXIMUM)


def refused(charger, parameter, value):
    before = charger.parameters[parameter]
    with pytest.raises(OutOfRange) as refusal:
        charger.write(parameter, value)
    assert charger.parameters[parameter] == before
    return refusal.value.direction


@pytest.mark.spec("C-154")
def test_the_model_knows_the_limits_that_the_table_prints_as_other_entries():
    def reference(cell):
        return Parameter(int(cell.partition(":")[2], 16)) if ":" in cell else None

    printed = {
        Parameter(int(row.sub, 16)): (reference(row.low), reference(row.high))
        for row in table()
        if row.index == "2002" and ":" in row.low + row.high
    }
    assert printed == LIMITS


@pytest.mark.spec("C-150", "C-151")
@pytest.mark.parametrize("kind", TYPES.values(), ids=lambda kind: kind.name)
def test_the_factory_settings_are_least_voltage_and_most_current(kind):
    values = factory(kind)
    assert values[Parameter.VOLTAGE_SETPOINT] == kind.minimum_voltage
    assert values[Parameter.CURRENT_SETPOINT] == kind.maximum_current


@pytest.mark.spec("C-150", "C-151", "C-158", "C-161")
@pytest.mark.parametrize(
    ("names", "low", "high"),
    [
        (VOLTAGE, 2000, 10000),
        (CURRENT, 500, 4000),
        (WIDTH, 300, 3000),
    ],
)
def test_a_setpoint_stays_within_the_limits_of_the_moment(charger, names, low, high):
    setpoint, minimum, maximum = names
    charger.write(minimum, low)
    charger.write(maximum, high)
    assert refused(charger, setpoint, low - 1) is Direction.LOW
    assert refused(charger, setpoint, high + 1) is Direction.HIGH
    for value in (low, high):
        charger.write(setpoint, value)
        assert charger.parameters[setpoint] == value


@pytest.mark.spec("C-154", "C-161")
@pytest.mark.parametrize(
    ("minimum", "maximum", "middle"),
    [
        (Parameter.VOLTAGE_MINIMUM, Parameter.VOLTAGE_MAXIMUM, 7000),
        (Parameter.CURRENT_MINIMUM, Parameter.CURRENT_MAXIMUM, 2000),
        (Parameter.WEB_WIDTH_MINIMUM, Parameter.WEB_WIDTH_MAXIMUM, 2500),
    ],
)
def test_a_minimum_never_passes_its_maximum(charger, minimum, maximum, middle):
    charger.write(minimum, middle)
    assert refused(charger, maximum, middle - 1) is Direction.LOW
    charger.write(maximum, middle)
    assert refused(charger, minimum, middle + 1) is Direction.HIGH


@pytest.mark.spec("C-155", "C-160")
@pytest.mark.parametrize(
    ("names", "low", "value", "high"),
    [
        (VOLTAGE, 4000, 5000, 6000),
        (CURRENT, 1000, 2000, 3000),
        (WIDTH, 1000, 2000, 3000),
    ],
)
def test_a_limit_that_passes_a_setpoint_takes_it_along(charger, names, low, value, high):
    setpoint, minimum, maximum = names
    charger.write(setpoint, value)
    charger.write(minimum, low)
    charger.write(maximum, high)
    assert charger.parameters[setpoint] == value
    charger.write(minimum, value + 1)
    assert charger.parameters[setpoint] == value + 1
    charger.write(minimum, low)
    charger.write(maximum, value - 1)
    assert charger.parameters[setpoint] == value - 1


@pytest.mark.spec("C-156")
@pytest.mark.parametrize("kind", TYPES.values(), ids=lambda kind: kind.name)
def test_modes_as_the_types_have_them(kind):
    esa = kind is PCTL
    default = {PCMT: 4, PCTL: 5}.get(kind, 3)
    assert (kind.mode, kind.lowest_mode, kind.highest_mode) == (default, 5 * esa or 3, 7 * esa or 4)
    assert factory(kind)[Parameter.MODE] == default


@pytest.mark.spec("C-115")
def test_a_restored_release_mode_takes_the_release_of_the_bus_away(charger, switch_on):
    switch_on(charger)
    charger.load(factory(PCSC))
    assert not charger.charging_active


@pytest.mark.spec("C-115")
def test_restored_values_come_back_as_they_were(charger):
    charger.write(Parameter.VOLTAGE_SETPOINT, 25000)
    charger.write(Parameter.VOLTAGE_MINIMUM, 20000)
    charger.load(factory(PCSC))
    assert {name: charger.parameters[name] for name in Parameter} == dict(factory(PCSC))
