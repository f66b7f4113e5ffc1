from itertools import product
from math import sqrt

import pytest

from canopen_twins.devices.topcon.model.loads import (
    Battery,
    CurrentSink,
    PowerSink,
    Resistor,
    Short,
)
from canopen_twins.devices.topcon.model.states import Mode

CV, CC, CP = Mode.VOLTAGE, Mode.CURRENT, Mode.POWER
A, B, EXAMPLE = "TCP-32-400", "TCP-16-100", "EXAMPLE-100-800-32"

# unit, set values U I P Ri in parts, load, readings U I P in parts, mode
POINTS = [
    (A, (2000, 4000, 4000, 0), "open", (2000, 0, 0), CV),
    (A, (4000, 2000, 4000, 0), "resistor 4", (2000, 2000, 1250), CC),
    (A, (4000, 4000, 4000, 0), "resistor 4", (3578, 3578, 4000), CP),
    (A, (4000, 1000, 4000, 0), "short", (1, 1000, 0), CC),
    (A, (3000, 800, 4000, 0), "battery 350 0.1", (3500, -7, -8), CV),
    (A, (2000, 1000, 4000, 0), "sink 30", (8, 1000, 3), CC),
    (B, (2000, 4000, 4000, 800), "resistor 0.8", (1600, 1000, 500), CV),
    (B, (4000, 4000, 2300, 0), "resistor 1", (3837, 1918, 2300), CP),
    (EXAMPLE, (1340, 750, 1250, 0), "resistor 0.05", (300, 750, 141), CC),
]


def readings(stage):
    unit = stage.unit
    return (
        stage.voltage / unit.nominal_voltage * 4000,
        stage.current / unit.maximum_current * 4000,
        stage.power / unit.nominal_power * 4000,
    )


@pytest.mark.spec("T-180", "T-181", "T-182", "T-183", "A-52")
@pytest.mark.parametrize("point", POINTS)
def test_a_settled_output_reads_as_tabulated(running, point):
    unit, parts, load, expected, mode = point
    stage = running(unit, load, parts)
    voltage, current, power = readings(stage)
    assert voltage == pytest.approx(expected[0], abs=2)
    assert current == pytest.approx(expected[1], abs=2)
    assert power == pytest.approx(expected[2], abs=4)
    assert stage.mode is mode


@pytest.mark.spec("T-170", "T-171", "T-172", "T-173")
def test_the_four_examples_of_set_values_are_true_on_one_unit(power_on):
    stage = power_on(EXAMPLE, parts=(1340, 750, 1250, 800))
    assert stage.voltage_reference == 33.5
    assert stage.current_reference == 150
    assert stage.power_reference == 10_000
    assert stage.resistance_reference == 0.2


GRID = list(product((40.0, 200.0, 400.0), (5.0, 30.0, 100.0), (1e3, 8e3, 32e3), (0.0, 0.5)))


def settle(running, load, point):
    stage = running()
    stage.load = load
    stage.voltage_reference, stage.current_reference = point[:2]
    stage.power_reference, stage.resistance_reference = point[2:]
    stage.step(5.0)
    assert stage.rest > 0
    return stage


@pytest.mark.parametrize("point", GRID)
@pytest.mark.parametrize("ohm", [0.5, 4.0, 10.0, 1000.0])
def test_a_resistor_takes_the_least_of_three_currents(running, point, ohm):
    stage = settle(running, Resistor(ohm), point)
    voltage, current, power, resistance = point
    resistance = max(resistance, stage.unit.droop)
    limits = {
        CV: voltage / (ohm + resistance),
        CC: current,
        CP: sqrt(power / ohm),
    }
    assert stage.current == pytest.approx(min(limits.values()), rel=1e-6)
    assert stage.voltage == pytest.approx(stage.current * ohm)
    assert limits[stage.mode] == pytest.approx(min(limits.values()))


@pytest.mark.parametrize("point", GRID)
@pytest.mark.parametrize("battery", [Battery(48, 0.02, True), Battery(350, 0.1, True)])
def test_a_battery_behind_a_diode_is_charged_or_left_alone(running, point, battery):
    stage = settle(running, battery, point)
    voltage, current, power, resistance = point
    inner, volts = battery.ohm, battery.volts
    by_voltage = (voltage - volts) / (inner + max(resistance, stage.unit.droop))
    by_power = (-volts + sqrt(volts**2 + 4 * inner * power)) / (2 * inner)
    expected = max(0.0, min(by_voltage, current, by_power))
    assert stage.current == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("point", GRID)
@pytest.mark.parametrize("amps", [2.0, 20.0])
def test_a_current_sink_leaves_the_voltage_to_the_unit(running, point, amps):
    stage = settle(running, CurrentSink(amps), point)
    voltage, current, power, resistance = point
    if amps < current:
        sagged = voltage - max(resistance, stage.unit.droop) * amps
        assert stage.voltage == pytest.approx(min(sagged, power / amps), rel=1e-6)
        assert stage.current == pytest.approx(amps)
    else:
        assert stage.current == pytest.approx(current)
        assert stage.voltage < 1.0


@pytest.mark.parametrize("watts", [0.0, 500.0, 5000.0, 20_000.0])
def test_a_power_sink_takes_its_power(running, watts):
    stage = running(load=f"power {watts} 250", parts=(3200, 4000, 4000, 0))
    assert stage.power == pytest.approx(watts)
    assert stage.mode is CV


def test_a_power_sink_too_strong_for_the_power_limit_pulls_the_output_down(running):
    stage = running(load="power 5000", parts=(2000, 4000, 4000, 0))
    assert stage.power == pytest.approx(5000)
    stage.power_reference = 4000
    stage.step(3.0)
    assert stage.mode is CP
    assert stage.power == pytest.approx(4000)
    assert stage.voltage == pytest.approx(60 * 4000 / 5000)  # under its minimum of 60 V


def test_a_power_sink_does_not_start_on_a_weak_supply(running):
    stage = running(load="power 5000", parts=(2000, 3000, 4000, 0))  # 75 A; it wants 83 A
    assert stage.voltage < PowerSink(5000).minimum
    assert stage.mode is CC


def test_power_moves_a_loaded_unit_from_voltage_to_power_control(running):
    stage = running(load="resistor 4", parts=(2000, 4000, 4000, 0))
    assert stage.mode is CV
    stage.power_reference = 2500
    stage.step(1.0)
    assert stage.mode is CP
    assert stage.voltage == pytest.approx(100)


def test_with_equal_limits_voltage_is_named_before_current_before_power(running):
    stage = running()
    assert stage.mode is CV  # everything 0: no current, no voltage
    stage.load = Short()
    stage.voltage_reference, stage.current_reference = 400, 20
    stage.power_reference = 0.8  # 20 A on 2 mOhm
    stage.step(1.0)
    assert stage.current == pytest.approx(20)
    assert stage.mode is CC


@pytest.mark.spec("A-43")
def test_a_one_quadrant_unit_does_not_discharge_a_battery(running):
    stage = running(load="battery 350 0.1", parts=(3000, 800, 4000, 0))
    assert stage.current == pytest.approx(-stage.voltage / stage.unit.bleeder)


@pytest.mark.spec("A-43")
@pytest.mark.parametrize(("volts", "current", "mode"), [(300.0, -50.0, CC), (349.0, -10.0, CV)])
def test_a_unit_with_the_q4_option_takes_current_in(running, volts, current, mode):
    q4 = {"sink_current": 50.0}
    stage = running(load="battery 350 0.1", parts=(0, 4000, 4000, 0), figures=q4)
    stage.voltage_reference = volts
    stage.step(1.0)
    assert stage.current == pytest.approx(current, abs=0.2)
    assert stage.mode is mode
    assert stage.power < 0
    assert stage.loss >= stage.unit.idle_power  # taking in costs as giving out does
