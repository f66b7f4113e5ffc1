from math import pi

import pytest

from canopen_twins.devices.topcon.model.loads import parse_load

CV = (2000, 4000, 4000, 0)


def overshoot(stage, load):
    """Volts above the set value, a tick after another load has been connected."""
    stage.load = parse_load(load)
    stage.step(0.001)
    return stage.voltage - stage.voltage_reference


@pytest.mark.spec("A-90")
@pytest.mark.parametrize(
    ("load", "amps"), [("resistor 4", 50), ("sink 30", 30), ("resistor 20", 10)]
)
def test_a_load_that_is_let_go_lifts_the_output_until_the_control_has_followed(running, load, amps):
    stage = running(load=load, parts=CV)
    expected = amps / (2 * pi * 2000) / stage.unit.capacitance  # 2 kHz, 0.5 mF
    bleeder = 200 / 2000 * 0.001 / stage.unit.capacitance  # in the rest of the tick
    assert overshoot(stage, "open") == pytest.approx(expected - bleeder, abs=0.02)
    assert stage.mode.name == "VOLTAGE"
    stage.step(5.0)  # it cannot sink: the bleeder brings it down
    assert stage.voltage == pytest.approx(200)


@pytest.mark.spec("A-90")
def test_opening_a_winding_lifts_the_output_as_well(running):
    stage = running(load="inductor 4 0.1", parts=CV)
    assert overshoot(stage, "open") == pytest.approx(8, abs=0.3)


@pytest.mark.spec("A-90")
def test_a_dump_near_the_level_trips(running):
    stage = running(load="resistor 4", parts=CV)
    stage.overvoltage_level = 205.0
    overshoot(stage, "open")
    assert stage.errors == (0x30,)


@pytest.mark.spec("A-90")
@pytest.mark.parametrize("load", ["resistor 4", "resistor 2", "short", "battery 200 1"])
def test_a_load_that_takes_as_much_or_more_lifts_nothing(running, load):
    stage = running(load="resistor 4", parts=CV)
    assert overshoot(stage, load) < 0.1


@pytest.mark.spec("A-90")
def test_an_output_that_is_off_has_nothing_to_overshoot(power_on):
    stage = power_on(load="battery 350 0.1")
    stage.step(1.0)
    assert stage.voltage < 350
    assert overshoot(stage, "open") < 350


@pytest.mark.spec("A-90")
def test_a_wider_bandwidth_makes_it_smaller(running):
    stage = running(load="resistor 4", parts=CV, figures={"control_bandwidth": 2e5})
    assert overshoot(stage, "open") < 0.1


@pytest.mark.spec("A-90")
def test_a_q4_unit_that_is_let_go_while_it_takes_in_sags(running):
    q4 = {"sink_current": 100.0}
    stage = running(load="battery 350 0.1", parts=(3000, 4000, 4000, 0), figures=q4)
    assert stage.current == pytest.approx(-100)
    before = stage.voltage
    stage.load = parse_load("open")
    stage.step(0.001)
    assert stage.voltage < before - 10
