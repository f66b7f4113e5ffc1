import pytest

from canopen_twins import Bench

from .bus import run, state_of_output


@pytest.mark.spec("A-78")
def test_run_works_once_the_unit_has_booted():
    bench = Bench("topcon", node_id=5, ready_time=2.0)
    assert bench.sent == ["705#00"]  # the card does not wait for the unit
    run(bench, voltage=2000)
    bench.run(1.9)
    assert state_of_output(bench) == 0
    bench.run(0.2)
    assert state_of_output(bench) == 0  # a RUN that came too early is not remembered
    bench.sdo["Run command"].raw = 1
    assert state_of_output(bench) == 0x0003


@pytest.mark.spec("A-79")
def test_readings_are_steady_unless_noise_is_wanted():
    def readings(**settings):
        bench = Bench("topcon", node_id=5, load="resistor 4", **settings)
        run(bench, voltage=2000)
        bench.run(1.0)
        return [bench.run(0.001) or bench.sdo["Actual voltage"].raw for _ in range(200)]

    assert set(readings()) == {2000}
    noisy = readings(noise=2)
    assert {1998, 1999, 2000, 2001, 2002} >= set(noisy) > {2000}
    assert noisy == readings(noise=2)
    assert noisy != readings(noise=2, seed=1)


@pytest.mark.spec("A-84")
def test_the_air_around_the_unit():
    cool, warm = (Bench("topcon", **settings) for settings in ({}, {"ambient": 60}))
    assert cool.device.report["heat sink [degC]"] == 25
    assert warm.device.report["heat sink [degC]"] == 60
    warm.set(ambient=20)
    warm.run(1000)
    assert warm.device.report["heat sink [degC]"] == pytest.approx(20, abs=0.1)


@pytest.mark.parametrize(
    ("load", "voltage", "current"),
    [
        ("open", 2000, 0),
        ("resistor 4", 2000, 2000),
        ("battery 100 1", 2000, 4000),
        ("sink 30", 2000, 1200),
        ("power 5000", 2000, 1000),
        ("short", 2, 4000),
        ("inductor 4 0.001", 2000, 2000),
    ],
)
def test_loads_can_be_changed_while_the_output_is_on(topcon, load, voltage, current):
    run(topcon, voltage=2000)
    topcon.run(1.0)
    topcon.set(load=load)
    topcon.run(3.0)
    assert topcon.sdo["Actual voltage"].raw == pytest.approx(voltage, abs=2)
    assert topcon.sdo["Actual current"].raw == pytest.approx(current, abs=2)
