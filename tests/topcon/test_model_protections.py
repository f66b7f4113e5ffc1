import pytest

from canopen_twins.devices.topcon.model.loads import Battery, Resistor, Short
from canopen_twins.devices.topcon.model.states import StageState

CV = (2000, 4000, 4000, 0)


@pytest.mark.spec("T-190", "A-54")
@pytest.mark.parametrize("parts", [1, 1234, 2000, 3333, 4000])
def test_a_voltage_of_exactly_its_level_does_not_trip(power_on, parts):
    stage = power_on(parts=(parts, 4000, 4000, 0))
    stage.overvoltage_level = parts / 4000 * 400
    stage.run()
    stage.step(1.0)
    assert stage.errors == ()
    stage.overvoltage_level = (parts - 1) / 4000 * 400
    stage.step(0.001)
    assert stage.errors == (0x30,)


@pytest.mark.spec("A-54", "A-55")
def test_levels_of_zero_are_legal_and_trip_whatever_is_not_zero(power_on):
    stage = power_on(parts=CV)
    stage.overvoltage_level = stage.overcurrent_level = 0.0
    stage.step(1.0)
    assert stage.errors == ()
    stage.run()
    stage.step(0.001)
    assert stage.errors == (0x30,)
    stage.step(30.0)
    stage.reset()
    stage.step(1.0)
    assert stage.errors == ()


@pytest.mark.spec("T-191", "A-55")
@pytest.mark.parametrize("parts", [1, 1234, 2000, 3333, 4000])
def test_a_current_of_exactly_its_level_does_not_trip(power_on, parts):
    stage = power_on(load="resistor 0.3", parts=(4000, parts, 4000, 0))
    stage.overcurrent_level = parts / 4000 * 100
    stage.run()
    stage.step(1.0)
    assert stage.errors == ()
    stage.overcurrent_level = (parts - 1) / 4000 * 100
    stage.step(0.004)
    assert stage.errors == ()
    stage.step(0.001)
    assert stage.errors == (0x21,)


def test_delays_are_those_of_the_unit_type(running):
    stage = running(parts=CV, figures={"overvoltage_delay": 0.03})
    stage.overvoltage_level = 100.0
    stage.step(0.029)
    assert stage.errors == ()
    stage.step(0.001)
    assert stage.errors == (0x30,)


@pytest.mark.spec("A-57")
@pytest.mark.parametrize(("when_off", "errors"), [(True, (0x30,)), (False, ())])
def test_a_battery_above_the_level_trips_an_output_that_is_off(power_on, when_off, errors):
    stage = power_on(overvoltage_when_off=when_off)
    stage.overvoltage_level = 300.0
    stage.load = Battery(350, 0.1)
    stage.step(1.0)
    assert stage.errors == errors
    stage.run()
    stage.step(0.002)
    assert stage.errors == (0x30,)


def test_current_that_the_unit_does_not_drive_is_no_overcurrent(running):
    stage = running(load="inductor 0.5 1", parts=(400, 4000, 4000, 0))
    stage.step(20.0)
    assert stage.current == pytest.approx(80, rel=1e-3)
    stage.stop()
    stage.overcurrent_level = stage.overcurrent_warning = 20.0
    stage.step(1.0)
    assert stage.current > 40
    assert (stage.errors, stage.warning) == ((), False)


@pytest.mark.spec("T-192")
def test_a_current_over_the_derated_maximum_trips_after_its_delay(power_on):
    stage = power_on(parts=(4000, 4000, 4000, 0), ambient=89.0, figures={"capacitance": 2.0})
    stage.overcurrent_level = 1000.0
    stage.circuit.voltage = 400.0  # a charged bank, many times the filter of a unit
    stage.run()
    stage.load = Resistor(4.0)  # 100 A at 70 % of the maximum current
    stage.step(0.009)
    assert stage.errors == ()
    stage.step(0.001)
    assert stage.errors == (0x25,)


def test_a_hot_unit_that_is_off_has_no_overcurrent(power_on):
    stage = power_on(ambient=89.0, figures={"capacitance": 2.0})
    stage.circuit.voltage = 400.0
    stage.load = Resistor(4.0)
    stage.step(0.1)
    assert stage.current > 90
    assert stage.errors == ()


def test_a_cold_unit_has_no_derated_maximum(power_on):
    stage = power_on(parts=(4000, 4000, 4000, 0), figures={"capacitance": 2.0})
    stage.overcurrent_level = 1000.0
    stage.circuit.voltage = 400.0
    stage.run()
    stage.load = Resistor(2.0)
    stage.step(0.1)
    assert stage.current > 150
    assert stage.errors == ()


@pytest.mark.spec("T-193")
def test_a_heat_sink_at_95_degrees_trips(power_on):
    stage = power_on(ambient=100.0)
    stage.step(0.001)
    assert stage.errors == (0x51,)


def test_the_current_limit_at_rated_current_never_fills_the_i2t_store(running):
    stage = running(load="resistor 3", parts=(4000, 4000, 4000, 0))
    assert stage.current == pytest.approx(100)
    stage.step(3600.0)
    assert stage.store.charge < 1e-3 * stage.unit.i2t_limit
    assert stage.errors == ()


def test_a_short_trips_nothing_within_the_delay_of_the_overcurrent_protection(running):
    stage = running(parts=(4000, 4000, 4000, 0))
    stage.load = Short()
    stage.step(1.0)
    assert stage.errors == ()
    assert stage.current == pytest.approx(100)


@pytest.mark.spec("T-194")
@pytest.mark.parametrize(("connection", "count"), [("parallel", 0xD6), ("series", 0xD5)])
def test_a_silent_slave_takes_the_system_down(power_on, connection, count):
    stage = power_on(units=2, connection=connection, parts=CV)
    stage.run()
    stage.slave_silent = True
    stage.step(0.099)
    assert stage.running
    stage.step(0.001)
    assert stage.errors == (0x67,)
    stage.reset()
    assert stage.errors == (count, 0xDA)  # one unit short of what is set
    stage.step(1.0)
    stage.reset()
    assert stage.errors == (count, 0xDA)
    stage.slave_silent = False
    stage.reset()
    assert stage.errors == ()
    assert stage.state is StageState.READY


@pytest.mark.spec("T-190", "T-191")
def test_a_trip_turns_the_converter_off_in_the_same_tick(running):
    stage = running(load="resistor 4", parts=CV)
    stage.interlock_closed = False
    stage.step(0.001)
    assert not stage.running
    assert stage.mode.name == "OFF"
    stage.step(0.02)
    assert stage.voltage < 0.1


def test_a_trip_leaves_the_set_values_as_they_were(running):
    stage = running(load="inductor 4 0.01", parts=CV)
    stage.trip(0x23)
    stage.step(1.0)
    assert (stage.voltage_reference, stage.current_reference) == (200, 100)


def test_errors_are_listed_in_the_order_they_came(running):
    stage = running(parts=CV)
    stage.interlock_closed = False
    stage.step(0.001)
    stage.supplies = {"5V": 0.0}
    stage.step(0.001)
    stage.supplies = {"5V": 0.0, "24V": 0.0}
    stage.mains = 300.0
    stage.step(1.0)
    assert stage.errors == (0xF2, 0x43, 0x4D, 0x4B, 0x49)
