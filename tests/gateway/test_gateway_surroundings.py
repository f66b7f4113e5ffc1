import pytest

from canopen_twins import Bench, UserError

from .bus import START, read


@pytest.fixture
def running(configured):
    """The engine at 1500 rpm, load let on, nothing from the master."""
    bench = configured()
    bench.run(15.0)
    return bench


def speed(bench):
    return bench.device.report["speed [rpm]"]


def test_consumers_can_be_switched_while_it_runs(running):
    running.set(load=100)
    running.run(0.4)
    assert 1400 < speed(running) < 1450
    running.run(10.0)
    assert speed(running) == pytest.approx(1500, abs=1)
    assert running.device.report["load [kW]"] == 100
    assert running.device.governor[2917] == 50.0


@pytest.mark.parametrize(("settings", "rpm"), [({"speed": 1200}, 1200), ({"droop": 4}, 1440)])
def test_setpoint_and_droop_act_while_it_runs(running, settings, rpm):
    running.set(load=200 if "droop" in settings else 0, **settings)
    running.run(20.0)
    assert speed(running) == pytest.approx(rpm, abs=1)


def test_the_start_switch_stops_it_and_starts_it_again(running):
    running.set(run=False)
    running.run(40.0)
    assert speed(running) == 0
    running.set(run=True)
    running.run(2.0)
    assert speed(running) > 600


def test_without_power_the_engine_runs_down(running):
    running.power_off()
    running.run(1.0)
    assert 1350 < speed(running) < 1450
    running.run(3600.0)
    assert speed(running) == 0
    assert running.device.report["oil pressure [bar]"] == 0
    running.power_on()
    running.run(0.3)
    assert running.device.report["governor"] == "running"


def test_power_that_comes_back_does_not_start_an_engine_nor_catch_one(configured):
    bench = configured(autostart=False)
    bench.set(run=False)
    bench.run(0.1)
    bench.set(run=True)
    bench.run(15.0)
    assert speed(bench) == pytest.approx(1500, abs=1)
    bench.power_off()
    bench.run(1.0)
    bench.power_on()
    bench.run(5.0)
    assert 0 < speed(bench) < 1100
    bench.run(30.0)
    assert speed(bench) == 0


def test_a_scenario_may_lead_the_engine_by_rpdos(bench):
    bench.send(START)
    bench.send("201#000000000000")
    bench.send("301#007D0000")  # 32000 of 64000 between 700 and 1800 rpm
    bench.run(20.0)
    assert speed(bench) == pytest.approx(1250, abs=1)
    assert read(bench, 0x2001, 1) == pytest.approx(16 * 1250, abs=16)


@pytest.mark.parametrize("setting", [{"boot_time": 1.0}, {"emcy": "assumed"}, {"config": "x"}])
def test_what_is_built_in_does_not_change_while_it_runs(running, setting):
    with pytest.raises(UserError, match="is taken over at power-on only"):
        running.set(**setting)


def test_consumers_from_the_beginning_wait_for_the_breaker():
    bench = Bench("gateway", load=50)
    bench.run(1.0)
    bench.set(run=True)
    bench.run(3.0)
    assert bench.device.report["load [kW]"] == 0.0
    bench.run(15.0)
    assert (speed(bench), bench.device.report["load [kW]"]) == (1500.0, 50.0)


def test_settings_that_are_refused_leave_both_units_as_they_were():
    bench = Bench("gateway", node_id=5)
    bench.power_off()
    with pytest.raises(UserError, match=r"overspeed: 1 rpm is not above"):
        bench.power_on(overspeed=1)
    assert bench.report["governor"] == "switched off"
    bench.power_on()
    assert bench.run(1.0)[0] == "705#00"
