"""Consumers, generator breaker, start and alarms of the assumed engine (A-53 to A-59)."""

import pytest

from canopen_twins import Bench, UserError

from .bus import START, heard, read

PLANT = {835: -5, 4835: 3}


def speed(bench):
    return bench.device.report["speed [rpm]"]


def load(bench):
    return bench.device.report["load [kW]"]


def errors(bench):
    return bench.device.report["errors of the governor"]


@pytest.mark.parametrize("kilowatts", [0.3, 0.5, 100, 200])
def test_an_engine_starts_with_consumers_waiting(configured, kilowatts):
    bench = configured(load=kilowatts)
    bench.run(20.0)
    assert speed(bench) == pytest.approx(1500, abs=1)
    assert load(bench) == kilowatts
    assert errors(bench) == []


def test_an_engine_stops_and_starts_under_load(configured):
    bench = configured(load=100)
    bench.run(20.0)
    bench.set(run=False)
    bench.run(0.1)
    assert load(bench) == 0
    bench.run(40.0)
    assert speed(bench) == 0
    bench.set(run=True)
    bench.run(20.0)
    assert (round(speed(bench)), load(bench)) == (1500, 100)


def test_the_breaker_closes_when_it_is_fast_enough_and_not_before(configured):
    bench = configured(load=50, speed=1400)
    bench.run(20.0)
    assert (round(speed(bench)), load(bench)) == (1400, 0)
    bench.set(breaker_speed=1300)
    bench.run(1.1)
    assert load(bench) == 50


def test_a_low_setpoint_opens_the_breaker_without_an_error(configured):
    bench = configured(load=50)
    bench.run(20.0)
    bench.set(speed=900)
    bench.run(20.0)
    assert (round(speed(bench)), load(bench), errors(bench)) == (900, 0, [])


def test_an_overloaded_engine_loses_its_consumers_tells_it_and_comes_back(configured):
    bench = configured(load=0)
    bench.run(20.0)
    bench.set(load=250)
    bench.run(10.0)
    assert (round(speed(bench)), load(bench), errors(bench)) == (1500, 0, [3035])
    bench.set(load=100)
    bench.run(5.0)
    assert load(bench) == 0
    bench.inject("clear_errors")
    bench.run(5.0)
    assert (load(bench), errors(bench)) == (100, [])


def test_a_step_of_215_kilowatts_never_ends_in_a_silent_standstill(configured):
    bench = configured(load=0)
    bench.run(20.0)
    for kilowatts in (205, 215, 225, 235, 260):
        bench.set(load=kilowatts)
        bench.run(10.0)
        assert round(speed(bench)) == 1500 or errors(bench)
        bench.set(load=0)
        bench.inject("clear_errors")
        bench.run(10.0)


def test_a_standing_engine_delivers_nothing(configured):
    bench = configured(run=False, load=200)
    bench.run(2.0)
    assert bench.device.governor["CurrentLoad"] == 0
    assert bench.device.report["generator breaker"] == "open"


@pytest.mark.spec("G-171", "G-174")
def test_load_enable_is_load_control_and_no_breaker(configured):
    bench = configured({**PLANT, 16480: 100}, load=100, droop=4)
    bench.send(START)
    bench.run(20.0)
    assert (round(speed(bench)), load(bench)) == (1470, 100)
    for _ in range(100):
        bench.send("201#0000")
        bench.run(0.05)
    assert (round(speed(bench)), load(bench)) == (1500, 100)
    bench.run(5.0)  # RPDO1 is missed
    assert (round(speed(bench)), load(bench)) == (1470, 100)


def test_an_engine_without_fuel_is_given_up_after_three_attempts(configured):
    bench = configured(run=False)
    bench.inject("fuel_lost")
    bench.set(run=True)
    cranked = 0
    for _ in range(500):
        bench.run(0.1)
        cranked += bench.device.system.governor.engine.starter
    assert cranked == pytest.approx(300, abs=3)
    assert errors(bench) == [3034]
    bench.clear("fuel_lost")
    bench.run(10.0)
    assert speed(bench) == 0
    bench.inject("clear_errors")
    bench.run(10.0)
    assert speed(bench) > 700


def test_an_engine_that_loses_its_fuel_has_stalled(configured):
    bench = configured()
    bench.run(15.0)
    bench.inject("fuel_lost")
    bench.run(30.0)
    assert speed(bench) == 0
    assert errors(bench) == [3035, 3036]


def test_oil_warns_and_then_stops_the_engine(configured):
    bench = configured()
    bench.run(20.0)
    bench.inject("oil_lost", percent=70)
    bench.run(5.0)
    assert (errors(bench), round(speed(bench))) == ([3030], 1500)
    bench.clear("oil_lost")
    bench.run(5.0)
    assert errors(bench) == []
    bench.inject("oil_lost", percent=100)
    bench.run(60.0)
    assert (errors(bench), speed(bench)) == ([3031], 0)


def test_charge_air_warns_and_then_stops_the_engine(configured):
    bench = configured()
    bench.run(20.0)
    bench.inject("cooling_lost", kelvin=65)
    bench.run(40.0)
    assert (errors(bench), round(speed(bench))) == ([3032], 1500)
    bench.inject("cooling_lost", kelvin=90)
    bench.run(60.0)
    assert (errors(bench), speed(bench)) == ([3033], 0)


@pytest.mark.parametrize(("fault", "given"), [("oil_lost", {"percent": 101})])
def test_what_no_engine_can_do_is_refused(configured, fault, given):
    with pytest.raises(UserError, match=r"percent 101 is not in 0\.\.100"):
        configured().inject(fault, **given)


@pytest.mark.parametrize("setting", [{}, {"run": True}])
def test_no_engine_starts_by_itself_at_power_on(setting):
    bench = Bench("gateway", **setting)
    bench.run(20.0)
    assert speed(bench) == 0


def test_an_engine_starts_when_the_switch_is_turned_on():
    bench = Bench("gateway")
    bench.run(0.3)
    bench.set(run=True)
    bench.run(5.0)
    assert speed(bench) > 700


def test_no_engine_starts_by_itself_after_an_overspeed():
    bench = Bench("gateway")
    bench.run(0.3)
    bench.set(run=True)
    bench.run(15.0)
    bench.inject("overspeed")
    bench.run(60.0)
    bench.inject("clear_errors")
    bench.run(20.0)
    assert speed(bench) == 0
    bench.set(run=False)
    bench.run(0.1)
    bench.set(run=True)
    bench.run(5.0)
    assert speed(bench) > 700


def test_a_full_external_setpoint_is_reached_without_overspeed(bench):
    bench.send(START)
    bench.run(0.1)
    for _ in range(300):
        bench.send("201#000000000000")
        bench.send("301#00FA0000")  # 64000 counts
        bench.run(0.1)
    assert round(speed(bench)) == 1800
    assert errors(bench) == [3011, 3022]  # those of RPDO3 and RPDO4
    assert bench.device.governor["SpeedSetp"] == 1800


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"overspeed": 1725}, "overspeed: 1725 rpm is not above highest_speed, 1800 rpm"),
        ({"speed": 1900}, "speed: 1900 rpm is above highest_speed, 1800 rpm"),
    ],
)
def test_trip_level_and_scale_end_have_to_agree(settings, told):
    with pytest.raises(UserError, match=told):
        Bench("gateway", **settings)


def test_an_engine_of_another_speed_range_trips_where_it_should(configured):
    bench = configured(highest_speed=1650, overspeed=1725)
    bench.run(15.0)
    bench.inject("overspeed", rpm=1730)
    bench.run(0.1)
    assert errors(bench) == [3004]


@pytest.mark.parametrize("kilowatts", [0, 100, 200])
def test_the_setpoint_is_reached_under_droop(configured, kilowatts):
    bench = configured({14402: 1}, droop=10, load=kilowatts)
    bench.run(40.0)
    assert round(speed(bench)) == 1500 - round(150 * kilowatts / 200)
    assert read(bench, 0x2000, 7) & 0x10


def test_the_setpoint_is_not_reached_on_the_way_to_it(configured):
    bench = configured({14402: 1})
    bench.send(START)
    bench.run(15.0)
    bench.set(speed=1000)
    words = heard(bench.run(1.5), "381")  # at 200 rpm/s
    assert words == ["0400"]
    assert heard(bench.run(5.0), "381")[-1] == "1400"


def test_the_measured_speed_is_as_noisy_as_the_settings_say(configured):
    def measured(**settings):
        bench = configured(**settings)
        bench.run(20.0)
        found = []
        for _ in range(200):
            bench.run(0.016)
            found.append(bench.device.governor["Speed"])
        return found

    assert max(abs(each - 1500) for each in measured()) < 0.1
    noisy = measured(speed_noise=2.0)
    assert 1.5 < max(noisy) - 1500 <= 2.1
    assert -2.1 <= min(noisy) - 1500 < -1.5
    assert noisy == measured(speed_noise=2.0) != measured(speed_noise=2.0, seed=1)
    assert 0.5 < max(measured(timing="typical")) - 1500 <= 1.1
    assert len(set(measured(speed_noise=2.0, run=False))) == 1


def test_a_governor_that_was_reset_governs_a_turning_engine_on(configured):
    bench = configured(autostart=False, run=False)
    bench.set(run=True)
    bench.run(15.0)
    bench.device.governor.reset()
    bench.run(5.0)
    assert round(speed(bench)) == 1500
