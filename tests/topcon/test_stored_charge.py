from math import exp

import pytest

from canopen_twins import Bench

from .bus import run, state_of_output

MODE = {"CC": 0x0005, "CV": 0x0003}


def volts(bench):
    return bench.sdo["Actual voltage"].raw / 10


def amps(bench):
    return bench.sdo["Actual current"].raw / 40


@pytest.mark.spec("A-91")
def test_a_charge_goes_from_current_to_voltage_control_by_itself():
    bench = Bench("topcon", node_id=5, load="battery 350 0.1 20Ah soc=0.5")
    run(bench, voltage=3700, current=1600)  # 370 V, 40 A
    bench.run(1.0)
    assert state_of_output(bench) == MODE["CC"]
    assert volts(bench) == pytest.approx(350 + 40 * 0.1, abs=0.2)
    bench.run(400.0)
    assert state_of_output(bench) == MODE["CC"]
    charged = 401 * 40 / 3600 / 20  # of the capacity
    assert volts(bench) == pytest.approx(350 + 70 * charged + 4, abs=0.2)
    bench.run(300.0)
    assert state_of_output(bench) == MODE["CV"]
    assert volts(bench) == 370
    assert 0 < amps(bench) < 40
    bench.run(3600.0)
    assert amps(bench) == 0
    assert state_of_output(bench) == MODE["CV"]


@pytest.mark.spec("A-91")
@pytest.mark.parametrize(
    ("load", "rests_at"),
    [
        ("battery 350 0.1 20Ah soc=0", 315.0),
        ("battery 350 0.1 20Ah", 350.0),
        ("battery 350 0.1 20Ah soc=1", 385.0),
        ("battery 350 0.1 20Ah soc=1 swing=0.1", 367.5),
        ("battery 350 0.1", 350.0),
        ("supercapacitor 10 F 0.1 ohm 48 V", 48.0),
    ],
)
def test_the_voltage_says_how_full_it_is(load, rests_at):
    bench = Bench("topcon", node_id=5, load=load)
    bench.run(0.1)
    assert volts(bench) == pytest.approx(rests_at, abs=0.1)


@pytest.mark.spec("A-91")
def test_a_supercapacitor_is_charged_by_a_current_and_drained_by_the_bleeder():
    bench = Bench("topcon", node_id=5, load="supercapacitor 10 F 0.1 ohm")
    run(bench, voltage=2000, current=400)  # 10 A into 10 F: 1 V/s
    bench.run(100.0)
    assert volts(bench) == pytest.approx(101, abs=0.3)
    assert state_of_output(bench) == MODE["CC"]
    bench.run(200.0)
    assert (volts(bench), state_of_output(bench)) == (200, MODE["CV"])
    bench.sdo["Run command"].raw = 0
    bench.run(20_000.0)  # 10 F and 2 kOhm
    assert volts(bench) == pytest.approx(200 * exp(-1), abs=0.2)


@pytest.mark.spec("A-91")
def test_the_charge_is_there_until_the_load_is_connected_anew():
    load = "battery 350 0.1 1Ah soc=0"
    bench = Bench("topcon", node_id=5, load=load)
    run(bench, voltage=3500)
    bench.run(600.0)
    assert volts(bench) == 350
    bench.sdo["Run command"].raw = 0
    bench.set(ambient=30)  # another setting leaves the load alone
    bench.power_off()
    bench.run(1.0)
    bench.power_on()
    assert volts(bench) == pytest.approx(350, abs=0.1)
    bench.set(load=load)
    bench.run(0.1)
    assert volts(bench) == pytest.approx(315, abs=0.1)


@pytest.mark.spec("A-91")
def test_a_diode_keeps_the_charge_from_the_bleeder():
    bench = Bench("topcon", node_id=5, load="battery 350 0.1 1Ah soc=1 diode")
    run(bench, voltage=3900)
    bench.run(30.0)
    bench.sdo["Run command"].raw = 0
    bench.run(30.0)
    assert volts(bench) == 0


@pytest.mark.spec("A-91")
def test_other_steps_lead_to_the_same_charge(running):
    load, parts = "battery 350 0.1 0.5 soc=0.2", (3700, 1600, 4000, 0)
    one, many = (running(load=load, parts=parts) for _ in range(2))
    one.step(40.0)
    for _ in range(40_000):
        many.step(0.001)
    assert one.voltage == pytest.approx(many.voltage, abs=0.004)
    assert one.current == pytest.approx(many.current, abs=0.02)


@pytest.mark.spec("A-91")
@pytest.mark.parametrize("command", [0, 1])
def test_a_day_of_a_battery_costs_few_steps(command, running):
    stage = running(load="battery 350 0.1 20 soc=0.2", parts=(3700, 400, 4000, 0))
    if not command:
        stage.stop()
    steps, step = [], stage.circuit.step
    stage.circuit.step = lambda *args: steps.append(step(*args))
    stage.step(24 * 3600.0)
    assert len(steps) < 20_000
