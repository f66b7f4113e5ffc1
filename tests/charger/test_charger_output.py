import pytest

from canopen_twins.devices.charger.model.load import OPEN, SHORT, AirGap, Load, Resistor, Web
from canopen_twins.devices.charger.model.output import Demand, regulate
from canopen_twins.devices.charger.model.surroundings import Surroundings
from canopen_twins.devices.charger.model.types import PCMT, PCRT, PCSC, PCTL, Mode, Quantity


def microamperes(charger):
    return charger.charging.output.current * 1e6


@pytest.mark.spec("C-162")
def test_a_pcsc_at_20_kv_drives_2_ma_and_40_w_through_its_bar(running):
    output = running.charging.output
    assert output.voltage == 20000
    assert microamperes(running) == pytest.approx(2000, abs=0.5)
    assert output.power == pytest.approx(40.0, abs=0.05)
    assert output.limiter is None
    assert running.charging.resistance == pytest.approx(10e6, rel=0.2)
    running.step(1.0)
    assert running.charging.resistance == 10_000_000


@pytest.mark.spec("C-163")
def test_the_power_limits_a_pcsc_at_26_28_kv(make, switch_on):
    charger = make(voltage_setpoint=30000)
    switch_on(charger)
    output = charger.charging.output
    assert output.limiter is Quantity.POWER
    assert output.voltage == pytest.approx(26280, abs=5)
    assert microamperes(charger) == pytest.approx(3810, abs=5)
    assert output.power == pytest.approx(100.0)


@pytest.mark.spec("C-156", "C-163")
def test_i_const_holds_1_ma_at_15_21_kv(make, switch_on):
    charger = make(mode=4, current_setpoint=1000, voltage_setpoint=30000)
    switch_on(charger)
    assert microamperes(charger) == pytest.approx(1000)
    assert charger.charging.output.voltage == pytest.approx(15210, abs=5)
    assert charger.charging.output.limiter is None


@pytest.mark.spec("C-163")
def test_the_current_setpoint_limits_u_const(make, switch_on):
    charger = make(voltage_setpoint=20000, current_setpoint=1000)
    switch_on(charger)
    assert charger.charging.output.limiter is Quantity.CURRENT
    assert microamperes(charger) == pytest.approx(1000)


@pytest.mark.spec("C-163")
def test_the_voltage_setpoint_limits_i_const(make, switch_on):
    charger = make(mode=4, current_setpoint=2500, voltage_setpoint=20000)
    switch_on(charger)
    assert charger.charging.output.limiter is Quantity.VOLTAGE
    assert charger.charging.output.voltage == 20000


@pytest.mark.spec("C-163")
def test_a_pcmt_as_delivered_stays_at_its_least_voltage(make, switch_on):
    charger = make(PCMT)
    switch_on(charger)
    assert charger.charging.output.voltage == 3000
    assert charger.charging.output.limiter is Quantity.VOLTAGE


@pytest.mark.spec("C-163")
@pytest.mark.parametrize("governing", [Quantity.VOLTAGE, Quantity.CURRENT])
def test_a_setpoint_that_is_just_met_limits_nothing(governing):
    demand = Demand(11000.0, 1100 * 1e-6, 12.1, governing, 500)
    load = Load(Resistor(10e6))
    assert load.current(11000.0) > demand.current  # by the last bit of a float
    assert regulate(demand, load) == (11000.0, Quantity.VOLTAGE)


def test_a_short_draws_the_set_current_at_no_voltage(running):
    running.surround(electrode=SHORT)
    running.step(0.1)
    assert running.charging.output.voltage < 1
    assert microamperes(running) == pytest.approx(5000)
    assert running.charging.output.limiter is Quantity.CURRENT


@pytest.mark.spec("C-181")
def test_an_open_terminal_draws_nothing_and_has_the_largest_resistance(running):
    running.surround(electrode=OPEN)
    running.step(2.0)
    assert running.charging.output.current == 0
    assert running.charging.output.voltage == 20000
    assert running.charging.resistance == 0xFFFFFFFF


@pytest.mark.spec("C-181")
def test_a_resistor_is_measured_as_what_it_is(running):
    running.surround(electrode=Resistor(20e6))
    running.step(2.0)
    assert running.charging.resistance == 20_000_000


def test_a_bar_starts_to_conduct_at_its_onset():
    bar = AirGap(length=2.0, onset=6000.0, coefficient=3.5714e-12)
    assert bar.current(6000.0) == 0
    assert bar.current(6001.0) > 0


def test_a_web_takes_charge_along_as_long_as_it_moves():
    bar = PCSC.bar
    still = Load(bar, web=Web(width=1.5, speed=0.0)).current(20e3)
    moving = Load(bar, web=Web(width=1.5, speed=2.0)).current(20e3)
    assert still == bar.current(20e3)
    assert moving - still == pytest.approx(60e-6)


def test_every_esa_mode_has_a_load_of_its_own(make, switch_on):
    currents = set()
    for mode in (Mode.ESA_FILM, Mode.ESA_PAPER, Mode.ESA_METALLISED):
        charger = make(PCTL, mode=mode, voltage_setpoint=10000)
        switch_on(charger)
        assert charger.charging.output.voltage == 10000
        currents.add(round(microamperes(charger)))
    assert len(currents) == 3


@pytest.mark.parametrize("kind", [PCSC, PCMT, PCRT], ids=lambda kind: kind.name)
def test_a_bar_can_take_the_highest_power_of_its_type(kind):
    load = Surroundings().load(kind, kind.mode)
    demand = Demand(
        kind.maximum_voltage, kind.maximum_current * 1e-6, kind.power, Quantity.VOLTAGE, 500
    )
    voltage, regulator = regulate(demand, load)
    assert regulator is Quantity.POWER
    assert load.power(voltage) == pytest.approx(kind.power)
