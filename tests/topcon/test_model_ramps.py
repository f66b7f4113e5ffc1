import pytest

FULL = (4000, 4000, 4000, 0)


def voltages(stage, count):
    values = []
    for _ in range(count):
        stage.step(0.001)
        values.append(stage.voltage)
    return values


def test_set_values_rise_by_the_start_slope_after_run(power_on):
    stage = power_on(parts=FULL)
    stage.run()
    stage.step(0.020)
    assert stage.ramps.voltage == pytest.approx(80)  # 400 V in 1.6 s / 16
    assert stage.ramps.current == pytest.approx(20)


def test_the_run_slope_holds_once_both_set_values_were_reached(power_on):
    stage = power_on(parts=(2000, 4000, 4000, 0))
    stage.run()
    stage.step(0.075)
    stage.voltage_reference = 400.0  # the voltage was there, the current still is on its way
    stage.step(0.001)
    assert stage.ramps.voltage == pytest.approx(204)
    stage.step(1.0)
    stage.voltage_reference = 200.0
    assert voltages(stage, 1) == pytest.approx([400.0], abs=1)  # an open output cannot follow
    assert stage.ramps.voltage == pytest.approx(360)  # ten times the start slope


def test_a_loaded_output_follows_the_run_slope_both_ways(running):
    stage = running(load="resistor 10", parts=(2000, 4000, 4000, 0))
    stage.voltage_reference = 280.0
    assert voltages(stage, 3) == pytest.approx([240, 280, 280], abs=0.01)
    stage.voltage_reference = 240.0
    assert voltages(stage, 40)[-1] == pytest.approx(240, abs=0.1)


def test_the_slope_is_that_of_the_unit_type(power_on):
    stage = power_on(parts=FULL, figures={"start_slope": 1.0})
    stage.run()
    stage.step(0.8)
    assert stage.ramps.voltage == pytest.approx(200)


def test_power_and_resistance_act_without_a_ramp(running):
    stage = running(load="resistor 4", parts=(2000, 4000, 4000, 0))
    stage.power_reference = 2500.0
    stage.step(0.02)  # five time constants of the filter, a tenth of the start ramp
    assert stage.voltage == pytest.approx(100, rel=1e-3)
    stage.power_reference, stage.resistance_reference = 32e3, 4.0
    stage.step(0.02)
    assert stage.voltage == pytest.approx(100, rel=1e-3)
    assert stage.mode.name == "VOLTAGE"


@pytest.mark.spec("T-178")
def test_stop_has_no_ramp(running):
    stage = running(load="resistor 0.5", parts=(400, 4000, 4000, 0))
    stage.stop()
    stage.step(0.010)
    assert stage.voltage < 0.1


def test_every_run_starts_from_zero_again(running):
    stage = running(parts=FULL)
    stage.stop()
    stage.run()
    stage.step(0.010)
    assert stage.ramps.voltage == pytest.approx(40)


@pytest.mark.spec("T-175", "A-48")
def test_run_on_a_running_output_changes_nothing(running):
    stage = running(parts=FULL)
    stage.run()
    stage.step(0.001)
    assert stage.ramps.voltage == 400.0
    assert stage.voltage == pytest.approx(400)


def test_a_rising_output_is_held_back_by_the_current_that_charges_its_capacitor(power_on):
    stage = power_on("TCP-16-100", parts=(4000, 40, 4000, 0))  # 2 A, 5 mF: 0.4 V a millisecond
    stage.run()
    stage.step(0.100)
    assert stage.mode.name == "CURRENT"
    assert stage.voltage == pytest.approx(40, abs=0.5)


def test_a_winding_carries_on_through_the_rectifier_after_stop(running):
    stage = running(load="inductor 2 0.2", parts=(1000, 4000, 4000, 0))
    stage.step(3.0)
    assert stage.current == pytest.approx(50, rel=1e-3)
    stage.stop()
    stage.step(0.05)
    assert stage.voltage == 0.0
    before = stage.current
    stage.step(0.1)  # the time constant L/R
    assert stage.current == pytest.approx(before * 0.368, rel=0.01)


def test_a_winding_just_connected_carries_no_current(running):
    stage = running(load="open", parts=(1000, 4000, 4000, 0))
    stage.load = running(load="inductor 2 0.2").load
    stage.step(0.001)
    assert stage.current == pytest.approx(100 * 0.001 / 0.2, rel=0.02)


def test_a_battery_keeps_its_voltage_on_an_output_that_is_off(running):
    stage = running(load="battery 350 0.1", parts=FULL)
    stage.stop()
    stage.step(1.0)
    assert stage.voltage == pytest.approx(350, abs=0.05)


def test_a_battery_behind_a_diode_does_not_feed_the_bleeder(running):
    stage = running(load="battery 350 0.1 diode")
    assert stage.voltage == 0.0
    assert stage.current == 0.0
