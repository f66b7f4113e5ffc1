import pytest

from canopen_twins.devices.charger.model.load import OPEN
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import ReleaseSource

MINUTE = 60.0


@pytest.fixture
def watched(make, switch_on):
    """A PCSC at 20 kV that knows its clean bar as 10 Mohm."""
    charger = make(voltage_setpoint=20000, pollution_detection=1, nominal_resistor=10_000_000)
    switch_on(charger, 2.0)
    return charger


@pytest.mark.spec("C-177", "C-178", "C-179")
@pytest.mark.parametrize("wanted", [1, 2])
def test_twenty_minutes_give_the_nominal_resistance(running, wanted):
    running.write(Parameter.POLLUTION_DETECTION, wanted)
    assert running.charging.calibrating
    running.step(20 * MINUTE - 0.01)
    assert running.charging.calibrating
    assert running.parameters[Parameter.POLLUTION_DETECTION] == wanted
    running.step(0.01)
    assert not running.charging.calibrating
    assert running.parameters[Parameter.NOMINAL_RESISTOR] == 10_000_000
    assert running.parameters[Parameter.POLLUTION_DETECTION] == 1


@pytest.mark.spec("C-177")
def test_with_a_nominal_resistance_monitoring_needs_no_calibration(make):
    assert not make(pollution_detection=1, nominal_resistor=5).charging.calibrating


@pytest.mark.spec("C-176", "C-178")
def test_a_calibration_waits_while_high_voltage_is_off(running):
    running.write(Parameter.POLLUTION_DETECTION, 2)
    running.step(10 * MINUTE)
    running.revoke(ReleaseSource.CANOPEN)
    running.step(60 * MINUTE)
    assert running.charging.calibrating
    running.grant(ReleaseSource.CANOPEN)
    running.step(10 * MINUTE - 0.01)
    assert running.charging.calibrating
    running.step(0.01)
    assert running.parameters[Parameter.NOMINAL_RESISTOR] == 10_000_000


@pytest.mark.spec("C-178")
def test_writing_0_stops_a_calibration_without_a_result(running):
    running.write(Parameter.POLLUTION_DETECTION, 2)
    running.step(19 * MINUTE)
    running.write(Parameter.POLLUTION_DETECTION, 0)
    running.step(5 * MINUTE)
    assert not running.charging.calibrating
    assert running.parameters[Parameter.NOMINAL_RESISTOR] == 0


@pytest.mark.spec("C-178")
def test_a_second_calibration_takes_twenty_minutes_again(watched):
    for _ in range(2):
        watched.write(Parameter.POLLUTION_DETECTION, 2)
        watched.step(20 * MINUTE - 0.01)
        assert watched.charging.calibrating
        watched.step(0.01)
        assert not watched.charging.calibrating


@pytest.mark.spec("C-179")
def test_an_open_terminal_is_calibrated_to_the_largest_resistance(running):
    running.surround(electrode=OPEN)
    running.step(1.0)
    running.write(Parameter.POLLUTION_DETECTION, 2)
    running.step(20 * MINUTE)
    assert running.parameters[Parameter.NOMINAL_RESISTOR] == 0xFFFFFFFF


@pytest.mark.spec("C-180")
def test_a_clean_bar_is_not_polluted(watched):
    assert watched.charging.pollution == 0


@pytest.mark.spec("C-180")
@pytest.mark.parametrize(
    ("dirt", "percent"),
    [({"leak": 40e6}, 20), ({"active": 0.8}, 25), ({"active": 0.2}, 100)],
)
def test_dirt_of_either_kind_moves_the_resistance_from_its_nominal(watched, dirt, percent):
    watched.surround(**dirt)
    watched.step(2.0)
    assert watched.charging.pollution == percent


@pytest.mark.spec("C-180")
def test_pollution_is_0_without_detection_without_voltage_and_while_calibrating(watched):
    watched.surround(active=0.5)
    watched.step(2.0)
    assert watched.charging.pollution == 100
    for value in (0, 2):
        watched.write(Parameter.POLLUTION_DETECTION, value)
        assert watched.charging.pollution == 0
    watched.write(Parameter.POLLUTION_DETECTION, 1)
    watched.revoke(ReleaseSource.CANOPEN)
    watched.step(0.01)
    assert watched.charging.pollution == 0


def test_ten_seconds_of_half_the_resistance_are_a_warning(watched, active):
    watched.surround(leak=9e6)
    watched.step(10.5)
    assert active(watched) == []
    watched.step(1.0)
    assert active(watched) == [("WARNING", "pollution_charging")]
    assert watched.charging_active


@pytest.mark.spec("C-177")
def test_a_nominal_resistance_that_is_taken_away_takes_twenty_minutes_to_find(watched):
    watched.write(Parameter.POLLUTION_DETECTION, 2)
    watched.step(20 * MINUTE)
    watched.write(Parameter.NOMINAL_RESISTOR, 0)
    watched.step(20 * MINUTE - 0.01)
    assert watched.charging.calibrating
    watched.step(0.01)
    assert not watched.charging.calibrating


@pytest.mark.spec("C-178")
@pytest.mark.parametrize("restart", [False, True])
def test_a_restart_begins_the_calibration_afresh(watched, restart):
    watched.write(Parameter.POLLUTION_DETECTION, 2)
    watched.step(10 * MINUTE)
    if restart:
        watched.restart({Parameter.POLLUTION_DETECTION: 2})
        watched.grant(ReleaseSource.CANOPEN)
    watched.step(10 * MINUTE)
    assert watched.charging.calibrating is restart
