from itertools import permutations

import pytest

from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.types import PCMT, PCSC, Variant


@pytest.mark.spec("C-153")
@pytest.mark.parametrize(
    ("percent", "voltage"), [(0, 1500), (1, 1500), (5, 1500), (6, 1800), (50, 15000), (100, 30000)]
)
def test_percent_of_the_highest_voltage_but_not_below_the_lowest(charger, percent, voltage):
    charger.write(Parameter.SETPOINT_PERCENT, percent)
    assert charger.parameters[Parameter.VOLTAGE_SETPOINT] == voltage
    assert charger.parameters[Parameter.SETPOINT_PERCENT] == percent
    assert charger.parameters[Parameter.CURRENT_SETPOINT] == 5000


@pytest.mark.spec("C-153")
def test_percent_of_the_highest_current_in_the_mode_that_holds_the_current(make):
    charger = make(PCMT, current_maximum=2001)
    charger.write(Parameter.SETPOINT_PERCENT, 50)
    assert charger.parameters[Parameter.CURRENT_SETPOINT] == 1001  # 1000.5, halves upwards
    assert charger.parameters[Parameter.VOLTAGE_SETPOINT] == 3000


@pytest.mark.spec("C-153")
def test_percent_refers_to_the_maximum_limit_and_not_to_the_type(charger):
    charger.write(Parameter.VOLTAGE_MAXIMUM, 10000)
    charger.write(Parameter.SETPOINT_PERCENT, 50)
    assert charger.parameters[Parameter.VOLTAGE_SETPOINT] == 5000


@pytest.mark.spec("C-153")
def test_percent_follows_the_setpoint_that_governs_and_no_other(charger):
    charger.write(Parameter.VOLTAGE_SETPOINT, 20000)
    assert charger.parameters[Parameter.SETPOINT_PERCENT] == 67
    charger.write(Parameter.CURRENT_SETPOINT, 500)
    assert charger.parameters[Parameter.SETPOINT_PERCENT] == 67
    charger.write(Parameter.MODE, 4)
    assert charger.parameters[Parameter.SETPOINT_PERCENT] == 10
    charger.write(Parameter.VOLTAGE_SETPOINT, 10000)
    assert charger.parameters[Parameter.SETPOINT_PERCENT] == 10


@pytest.mark.spec("C-153", "C-155")
@pytest.mark.parametrize("order", [*permutations(["setpoint", "limit", "mode"])])
@pytest.mark.parametrize("mode", [3, 4])
def test_percent_follows_setpoints_and_limits_in_every_order(charger, order, mode):
    writes = {
        "setpoint": {Parameter.VOLTAGE_SETPOINT: 9000, Parameter.CURRENT_SETPOINT: 1200},
        "limit": {Parameter.VOLTAGE_MAXIMUM: 20000, Parameter.CURRENT_MAXIMUM: 4000},
        "mode": {Parameter.MODE: mode},
    }
    for each in order:
        for parameter, value in writes[each].items():
            charger.write(parameter, value)
    assert charger.parameters[Parameter.SETPOINT_PERCENT] == {3: 45, 4: 30}[mode]


@pytest.mark.spec("C-153")
def test_nothing_is_converted_at_the_start(make):
    charger = make(PCMT)
    assert charger.parameters[Parameter.SETPOINT_PERCENT] == 5
    assert charger.parameters[Parameter.CURRENT_SETPOINT] == 2500


@pytest.mark.spec("C-140")
@pytest.mark.parametrize(
    ("written", "kept"), [(0, 0), (1, 0), (499, 0), (500, 500), (60000, 60000)]
)
def test_a_timeout_below_half_a_second_is_none(charger, written, kept):
    charger.write(Parameter.RELEASE_TIMEOUT, written)
    assert charger.parameters[Parameter.RELEASE_TIMEOUT] == kept


@pytest.mark.spec("C-159")
@pytest.mark.parametrize("mode", [3, 4])
@pytest.mark.parametrize(
    ("width", "factor", "current"),
    [
        (1500, 1000, 1500),
        (1234, 1001, 1235),  # 1235.234 is cut
        (1999, 1001, 2000),  # 2000.999 is cut
        (100, 1000, 250),  # raised to the least current
        (5000, 5000, 5000),  # lowered to the highest
    ],
)
def test_a_web_width_sets_the_current(charger, mode, width, factor, current):
    charger.write(Parameter.MODE, mode)
    charger.write(Parameter.CURRENT_WIDTH_FACTOR, factor)
    charger.write(Parameter.WEB_WIDTH, width)
    assert charger.parameters[Parameter.CURRENT_SETPOINT] == current


@pytest.mark.spec("C-158")
def test_a_width_of_zero_converts_nothing(charger):
    charger.write(Parameter.CURRENT_SETPOINT, 700)
    charger.write(Parameter.CURRENT_WIDTH_FACTOR, 2000)
    charger.write(Parameter.WEB_WIDTH, 0)
    assert charger.parameters[Parameter.CURRENT_SETPOINT] == 700


@pytest.mark.spec("C-159")
@pytest.mark.parametrize(
    ("parameter", "value", "current"),
    [
        (Parameter.CURRENT_WIDTH_FACTOR, 2000, 3000),
        (Parameter.WEB_WIDTH_MINIMUM, 2000, 2000),
        (Parameter.WEB_WIDTH_MAXIMUM, 1000, 1000),
        (Parameter.WEB_WIDTH_MINIMUM, 1000, 700),  # moves nothing
        (Parameter.WEB_WIDTH_MAXIMUM, 2000, 700),
    ],
)
def test_a_written_current_holds_until_the_width_or_its_factor_changes(
    charger, parameter, value, current
):
    charger.write(Parameter.WEB_WIDTH, 1500)
    charger.write(Parameter.CURRENT_SETPOINT, 700)
    charger.write(parameter, value)
    assert charger.parameters[Parameter.CURRENT_SETPOINT] == current


@pytest.mark.spec("C-195")
@pytest.mark.parametrize(("percent", "voltage"), [(100, 5000), (50, 2500), (20, 1000), (0, 1000)])
def test_percent_of_the_discharging_voltage(make, percent, voltage):
    charger = make(PCSC, Variant.A)
    charger.write(Parameter.SETPOINT_PERCENT_DISCHARGING, percent)
    assert charger.parameters[Parameter.VOLTAGE_SETPOINT_DISCHARGING] == voltage


@pytest.mark.spec("C-195")
def test_the_discharging_starts_with_its_highest_voltage_and_percent_follows_it(make):
    charger = make(PCSC, Variant.A)
    assert charger.parameters[Parameter.VOLTAGE_SETPOINT_DISCHARGING] == 5000
    charger.write(Parameter.VOLTAGE_SETPOINT_DISCHARGING, 3000)
    assert charger.parameters[Parameter.SETPOINT_PERCENT_DISCHARGING] == 60
