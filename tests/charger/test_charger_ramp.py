import pytest
from charger_bus import release

from canopen_twins.devices.charger.model.load import OPEN, SHORT, Resistor
from canopen_twins.devices.charger.model.output import Ramp
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import ReleaseSource
from canopen_twins.devices.charger.model.types import PCMT, PCRT, PCSC, Mode


def microamperes(charger):
    return charger.charging.output.current * 1e6


@pytest.mark.spec("C-157")
@pytest.mark.parametrize("ramp", [100, 500, 1234, 10000])
@pytest.mark.parametrize("voltage", [1500, 20000])
def test_switching_on_takes_the_ramp_time_whatever_the_step(make, switch_on, ramp, voltage):
    charger = make(ramp_time=ramp, voltage_setpoint=voltage)
    ticks = -(-ramp // 10)
    switch_on(charger, (ticks - 1) / 100)
    assert charger.charging.output.voltage < voltage
    charger.step(0.01)
    assert charger.charging.output.voltage == voltage


@pytest.mark.spec("C-157")
def test_a_new_setpoint_starts_a_new_ramp_from_where_the_last_one_was(make, switch_on):
    charger = make(voltage_setpoint=20000)
    switch_on(charger, 0.25)
    assert charger.charging.output.voltage == pytest.approx(10000)
    charger.write(Parameter.VOLTAGE_SETPOINT, 4000)
    charger.step(0.25)
    assert charger.charging.output.voltage == pytest.approx(7000)
    charger.step(0.25)
    assert charger.charging.output.voltage == 4000


@pytest.mark.spec("C-157")
def test_the_ramp_of_i_const_is_one_of_the_current(make, switch_on):
    charger = make(mode=4, current_setpoint=1000, voltage_setpoint=30000)
    switch_on(charger, 0.25)
    assert microamperes(charger) == pytest.approx(500)
    charger.step(0.25)
    assert microamperes(charger) == pytest.approx(1000)


@pytest.mark.spec("C-157")
def test_a_new_mode_starts_from_the_present_value_of_what_it_holds(running):
    running.write(Parameter.CURRENT_SETPOINT, 1000)
    running.write(Parameter.VOLTAGE_SETPOINT, 30000)
    running.write(Parameter.MODE, 4)
    running.step(0.25)
    assert microamperes(running) == pytest.approx((2000 + 1000) / 2, abs=1)


@pytest.mark.spec("C-157")
def test_a_set_value_that_acts_as_the_limiter_keeps_to_the_ramp_time(make, switch_on):
    charger = make(PCMT, ramp_time=10_000, current_setpoint=500)
    charger.surround(electrode=Resistor(120e6))
    switch_on(charger, 12.0)
    assert charger.charging.output.voltage == 3000
    charger.write(Parameter.VOLTAGE_SETPOINT, 50_000)
    charger.step(0.02)
    assert charger.charging.output.voltage == pytest.approx(3000 + 47_000 * 0.002)
    charger.step(4.98)
    assert charger.charging.output.voltage == pytest.approx(3000 + 47_000 * 0.5)
    charger.step(4.99)
    assert charger.charging.output.voltage < 50_000
    charger.step(0.01)
    assert charger.charging.output.voltage == 50_000


@pytest.mark.spec("C-157")
@pytest.mark.parametrize("kind", [PCSC, PCMT, PCRT], ids=lambda kind: kind.name)
@pytest.mark.parametrize("mode", [3, 4])
@pytest.mark.parametrize("changed", ["voltage_setpoint", "current_setpoint"])
@pytest.mark.parametrize("upwards", [True, False])
def test_no_change_of_a_set_value_is_faster_than_the_ramp(
    make, switch_on, kind, mode, changed, upwards
):
    quantity = changed.split("_")[0]
    low, high = getattr(kind, f"minimum_{quantity}"), getattr(kind, f"maximum_{quantity}")
    given = {"voltage_setpoint": kind.maximum_voltage, "current_setpoint": kind.maximum_current}
    values = [low, high] if upwards else [high, low]
    charger = make(kind, mode=mode, ramp_time=2000, **{**given, changed: values[0]})
    switch_on(charger, 4.0)
    output = charger.charging.output
    before, steepest = (output.voltage, output.current), [0.0, 0.0]
    charger.write(Parameter[changed.upper()], values[1])
    for _ in range(400):
        last = output.voltage, output.current
        charger.step(0.01)
        steps = abs(output.voltage - last[0]), abs(output.current - last[1])
        steepest = [max(*both) for both in zip(steepest, steps, strict=True)]
    whole = max(abs(output.voltage - before[0]), abs(kind.maximum_voltage - before[0]))
    evenly = steepest[0] <= 1.1 * whole / 200  # in I-Const it is the current that goes evenly
    evenly_in_current = steepest[1] <= 1.1 * abs(output.current - before[1]) / 200
    assert output.voltage != before[0]
    assert evenly or (mode == Mode.I_CONST and evenly_in_current)


@pytest.mark.spec("C-157")
def test_a_set_value_that_moves_nothing_begins_no_ramp(make, switch_on):
    charger = make(voltage_setpoint=20000)
    switch_on(charger, 0.25)
    charger.write(Parameter.CURRENT_SETPOINT, 4000)
    charger.step(0.25)
    assert charger.charging.output.voltage == 20000


def test_a_ramp_charges_cable_and_bar_below_the_onset(make, switch_on):
    charger = make(voltage_setpoint=5000, ramp_time=1000)
    switch_on(charger, 0.5)
    assert microamperes(charger) == pytest.approx(2e-9 * 5000 * 1e6)
    charger.step(0.5)
    assert microamperes(charger) == 0


def test_what_is_connected_says_how_fast_the_voltage_goes(make, switch_on):
    def left(electrode, seconds):
        charger = make(voltage_setpoint=20000)
        charger.surround(electrode=electrode)
        switch_on(charger)
        charger.revoke(ReleaseSource.CANOPEN)
        charger.step(seconds)
        return charger.charging.output.voltage

    assert left(SHORT, 0.01) == 0
    assert left(Resistor(10e6), 0.02) == pytest.approx(20000 / 2.718282)
    assert left(None, 0.1) == pytest.approx(20000 / 2.718282)
    assert left(OPEN, 1.0) > 19000
    assert left(OPEN, 30.0) == pytest.approx(20000 / 2.718282)
    assert left(OPEN, 3600.0) == 0


def test_a_release_on_what_is_left_does_not_pull_it_down(make, switch_on):
    charger = make(voltage_setpoint=20000)
    charger.surround(electrode=OPEN)
    switch_on(charger)
    charger.revoke(ReleaseSource.CANOPEN)
    charger.step(0.1)
    charger.grant(ReleaseSource.CANOPEN)
    lowest = 20000.0
    for _ in range(50):
        charger.step(0.01)
        lowest = min(lowest, charger.charging.output.voltage)
    assert lowest > 19500
    charger.write(Parameter.VOLTAGE_SETPOINT, 1500)
    charger.step(1.0)
    assert charger.charging.output.voltage > 18000
    assert charger.charging.output.current == 0


def test_what_is_left_outlives_the_supply(quiet):
    release(quiet)
    quiet.inject("open_electrode")
    quiet.run(0.1)
    quiet.power_off()
    quiet.run(10.0)
    assert quiet.device.report["voltage [V]"] == pytest.approx(20000 * 0.7165, rel=1e-3)
    quiet.power_on()
    assert quiet.sdo[0x6401][1].raw == pytest.approx(20000 * 0.7165, rel=1e-3)
    assert quiet.sdo[0x6401][2].raw == 0
    quiet.power_off()
    quiet.clear("open_electrode")
    quiet.run(2.0)
    quiet.power_on()
    assert quiet.sdo[0x6401][1].raw == 0


def test_a_setting_says_how_long_an_open_terminal_holds_its_charge(quiet):
    quiet.device.set(holding_time=2.0)
    release(quiet)
    quiet.inject("open_electrode")
    quiet.sdo[0x6200][1].raw = 0
    quiet.run(2.0)
    assert quiet.sdo[0x6401][1].raw == pytest.approx(20000 / 2.718282, abs=1)


def test_a_ramp_is_a_straight_line_and_stays_at_its_end():
    ramp = Ramp(start=100.0, end=200.0, begin=50, time=100)
    assert [ramp.at(tick) for tick in (50, 55, 60, 99)] == [100.0, 150.0, 200.0, 200.0]


def test_once_off_the_voltage_dies_away_without_a_current(running):
    running.revoke(ReleaseSource.CANOPEN)
    running.step(0.1)
    assert running.charging.output.voltage == pytest.approx(20000 / 2.718282, rel=1e-4)
    assert running.charging.output.current == 0
    assert running.charging.resistance == 0
    running.step(2.0)
    assert running.charging.output.voltage == 0
