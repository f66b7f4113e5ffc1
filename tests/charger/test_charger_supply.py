import pytest

from canopen_twins import Bench
from canopen_twins.devices.charger.model.surroundings import feed
from canopen_twins.devices.charger.model.thermal import Temperature

HOUR = 3600.0


@pytest.mark.spec("C-182")
def test_40_w_of_charging_draw_55_w_at_2_30_a_and_23_885_v(running):
    supply = running.supply
    assert supply.power == pytest.approx(55.0, abs=0.01)
    assert supply.current == pytest.approx(2.30, abs=0.005)
    assert supply.voltage == pytest.approx(23.885, abs=0.0005)
    assert 100 * supply.power / running.build.kind.supply_power == pytest.approx(39, abs=0.5)


@pytest.mark.spec("C-182")
def test_an_idle_charger_draws_5_w(charger):
    charger.step(0.01)
    assert charger.supply.power == 5.0


def test_the_drop_on_the_line_is_that_of_its_resistance():
    supply = feed(24.0, 80.0, 0.0)
    assert supply.voltage == pytest.approx(24.0 - 0.05 * supply.current)
    assert supply.voltage * supply.current == pytest.approx(supply.power)


@pytest.mark.parametrize("nominal", [0.0, 3.0])
def test_a_supply_that_breaks_down_is_no_error_of_the_arithmetic(nominal):
    assert feed(nominal, 100.0, 0.0).voltage == nominal / 2


@pytest.mark.spec("C-183")
@pytest.mark.parametrize(
    ("sensor", "end"),
    [("power_stage", 25 + 1.2 * 15), ("inside", 25 + 0.6 * 15), ("cascade", 25 + 6 * 2)],
)
def test_temperatures_settle_where_the_losses_heat_them_to(running, sensor, end):
    running.step(3 * HOUR)
    assert running.heating.at(running.now)[sensor] == pytest.approx(end, abs=0.01)


@pytest.mark.spec("C-183")
def test_a_temperature_has_gone_63_percent_of_its_way_after_its_time_constant():
    sensor = Temperature(resistance=1.0, time_constant=100.0)
    sensor.lead(0, 50.0, 25.0, 0.0)
    assert sensor.at(0) == 25
    assert sensor.at(10_000) == pytest.approx(25 + 50 * (1 - 1 / 2.718282))


def test_heat_from_outside_shows_at_once(charger):
    charger.surround(heat={"inside": 30.0})
    charger.step(0.01)
    assert charger.heating.at(charger.now)["inside"] == pytest.approx(55, abs=0.1)
    charger.surround(heat={})
    charger.step(0.01)
    assert charger.heating.at(charger.now)["inside"] == pytest.approx(25, abs=0.1)


@pytest.mark.parametrize(("power", "heat"), [(0.0, 0.0), (10.0, 0.0), (-10.0, 5.0), (0.5, 0.0)])
def test_between_two_whole_degrees_nothing_is_promised_that_does_not_hold(power, heat):
    sensor = Temperature(resistance=1.0, time_constant=1.0)
    sensor.lead(0, 3.0, 25.0, 0.0)
    sensor.lead(70, power, 25.0, heat)
    now = 70
    while (quiet := sensor.quiet(sensor.at(now))) < 1000:
        shown = {int(sensor.at(tick)) for tick in range(now, now + quiet)}
        assert len(shown) == 1
        now += quiet
    assert len({int(sensor.at(tick)) for tick in range(now, now + 1000)}) == 1


def test_it_is_as_warm_as_the_air_when_it_starts():
    bench = Bench("charger", ambient=40)
    assert [bench.sdo[0x2001][sub].raw for sub in (5, 6, 7)] == [40, 40, 40]


def test_heat_outlives_the_supply_and_cools_down_meanwhile(on):
    on.run(3600.0)
    hot = on.sdo[0x2001][5].raw
    on.power_off()
    on.run(60.0)
    on.power_on()
    warm = on.sdo[0x2001][5].raw
    on.power_off()
    on.run(36000.0)
    on.power_on()
    assert hot > warm > 25
    assert on.sdo[0x2001][5].raw == 25
