import pytest

from canopen_twins import Bench

from .bus import run, state_of_output

ERROR, WARNING = 0x8000, 0x4000
OVERVOLTAGE, OVERCURRENT = "085#0033053000000000", "085#0023032100000000"
I2T, DERATED = "085#0023032000000000", "085#0023032500000000"


def emergencies(bench):
    """Messages with the seconds since RUN or power-on at which they were sent."""
    return [
        (record.time, str(record.frame)) for record in bench.trace if record.frame.can_id == 0x85
    ]


def reset(bench):
    bench.sdo["Run command"].raw = 2
    return state_of_output(bench)


@pytest.mark.spec("T-190", "A-54", "A-80", "A-83")
def test_an_output_that_rises_above_its_level_trips(topcon):
    topcon.sdo["Overvoltage level"].raw = 2000
    run(topcon, voltage=3000)
    assert topcon.run(0.048) == []
    assert topcon.run(0.005) == [OVERVOLTAGE]  # 100 ms from 0 to full scale, level at one half
    assert state_of_output(topcon) == ERROR
    assert topcon.sdo["Error Register"].raw == 0x05
    assert topcon.sdo["Voltage reference"].raw == 3000
    topcon.run(5.0)
    assert topcon.sdo["Actual voltage"].raw < 20  # off, and discharged


@pytest.mark.spec("T-190", "A-54")
@pytest.mark.parametrize(
    ("level", "word"), [(1999, ERROR), (2000, 0x0003), (2001, 0x0003), (0, ERROR)]
)
def test_the_level_itself_is_not_above_it(topcon, level, word):
    run(topcon, voltage=2000)
    topcon.run(1.0)
    topcon.sdo["Overvoltage level"].raw = level
    topcon.run(1.0)
    assert state_of_output(topcon) == word


@pytest.mark.spec("A-54", "A-55")
def test_a_level_does_not_limit_the_set_value(topcon):
    topcon.sdo["Overvoltage level"].raw = 1000
    topcon.sdo["Overcurrent level"].raw = 1000
    topcon.sdo["Voltage reference"].raw = 4000
    topcon.sdo["Current reference"].raw = 4000
    assert topcon.sdo["Voltage reference"].raw == topcon.sdo["Current reference"].raw == 4000


@pytest.mark.spec("T-190", "A-49", "A-60")
def test_overvoltage_can_be_reset_once_the_output_has_fallen_below_its_level(topcon):
    run(topcon, voltage=3000)
    topcon.run(1.0)
    topcon.sdo["Overvoltage level"].raw = 2000
    topcon.run(0.1)
    assert reset(topcon) == ERROR  # 300 V fall with 1 s
    topcon.run(0.5)
    assert reset(topcon) == 0
    assert [frame for _, frame in emergencies(topcon)] == [OVERVOLTAGE, "085#0000000000000000"]


@pytest.mark.spec("T-191", "A-55", "A-80", "A-83")
def test_a_current_above_its_level_trips(topcon):
    topcon.set(load="resistor 5")
    topcon.sdo["Overcurrent level"].raw = 2000
    run(topcon, voltage=4000)
    topcon.run(0.060)
    assert emergencies(topcon) == []
    topcon.run(0.010)
    ((_, frame),) = emergencies(topcon)
    assert frame == OVERCURRENT
    assert state_of_output(topcon) == ERROR
    assert topcon.sdo["Error Register"].raw == 0x03


@pytest.mark.spec("T-191", "A-55")
@pytest.mark.parametrize(("level", "word"), [(1999, ERROR), (2000, 0x0005), (2001, 0x0005)])
def test_the_current_level_itself_is_not_above_it(topcon, level, word):
    topcon.set(load="resistor 4")
    run(topcon, current=2000)
    topcon.run(1.0)
    topcon.sdo["Overcurrent level"].raw = level
    topcon.run(1.0)
    assert state_of_output(topcon) == word


@pytest.mark.spec("A-83", "A-82")
def test_a_sudden_short_is_ridden_through(topcon):
    run(topcon, voltage=4000, current=1000)
    topcon.run(1.0)
    topcon.set(load="short")
    currents = [topcon.run(0.001) or topcon.sdo["Actual current"].raw for _ in range(5)]
    assert currents[0] > 8000  # the filter capacitor first
    assert currents[2:] == [pytest.approx(1000, abs=2)] * 3
    assert state_of_output(topcon) == 0x0005


@pytest.mark.spec("T-192", "A-83")
def test_more_than_the_permitted_current_fills_the_i2t_store(unit_file):
    file = unit_file(i2t_current=50.0, i2t_limit=3750.0)
    bench = Bench("topcon", node_id=5, unit="MINE", unit_file=file, load="resistor 4")
    run(bench)
    bench.run(0.5)
    assert state_of_output(bench) == 0x0009 | WARNING  # half full
    bench.run(0.5)
    ((time, frame),) = emergencies(bench)
    assert (time, frame) == (pytest.approx(0.755, abs=0.01), I2T)
    assert state_of_output(bench) == ERROR | WARNING


@pytest.mark.spec("T-192", "A-83")
def test_the_rated_current_never_trips_i2t(topcon):
    topcon.set(load="resistor 3.2")
    run(topcon)
    topcon.run(3600)
    assert (topcon.sdo["Actual current"].raw, emergencies(topcon)) == (4000, [])


@pytest.mark.spec("T-192", "A-83")
def test_derated_overcurrent_is_reached_by_injection(topcon):
    run(topcon, voltage=2000)
    topcon.inject("error", number=0x25)
    assert topcon.sent[-1] == DERATED
    assert state_of_output(topcon) == ERROR


@pytest.mark.spec("A-84")
@pytest.mark.parametrize(
    ("ambient", "warns_at", "degrees", "parts"),
    [(25, 900, 67.5, 4000), (45, 173, 86.3, 3942), (70, 27, 92.9, 2856)],
)
def test_a_warm_unit_warns_and_gives_less(ambient, warns_at, degrees, parts):
    bench = Bench("topcon", load="resistor 5", ambient=ambient)
    run(bench)
    bench.run(warns_at - 1)
    assert state_of_output(bench) & WARNING == 0
    bench.run(2)
    assert state_of_output(bench) & WARNING == (WARNING if warns_at < 900 else 0)
    bench.run(900 - warns_at)
    assert bench.device.report["heat sink [degC]"] == pytest.approx(degrees, abs=0.1)
    assert bench.sdo["Actual voltage"].raw == pytest.approx(parts, abs=3)
    assert state_of_output(bench) & ERROR == 0


@pytest.mark.spec("T-193", "A-83", "A-84")
def test_a_heat_sink_at_95_degrees_trips():
    bench = Bench("topcon", node_id=5, ambient=96)
    assert bench.run(0.01) == ["085#0042095100000000"]
    assert state_of_output(bench) == ERROR | WARNING


@pytest.mark.spec("A-57")
def test_after_a_battery_above_the_level_is_taken_away_the_error_can_be_reset():
    bench = Bench("topcon", node_id=5, load="battery 460 0.1")
    bench.run(0.1)
    assert reset(bench) == ERROR
    bench.set(load="open")
    bench.run(1.0)
    assert reset(bench) == 0


@pytest.mark.spec("A-82")
def test_a_battery_keeps_the_reading_with_the_output_off(topcon):
    topcon.set(load="battery 350 0.1")
    topcon.run(1.0)
    assert topcon.sdo["Actual voltage"].raw == pytest.approx(3500, abs=2)
    assert state_of_output(topcon) == 0


@pytest.mark.spec("A-80", "A-82")
def test_an_open_output_falls_with_its_bleeder(topcon):
    run(topcon, voltage=2000)
    topcon.run(1.0)
    topcon.sdo["Run command"].raw = 0
    topcon.run(1.0)  # 2 kOhm times 0.5 mF
    assert topcon.sdo["Actual voltage"].raw == pytest.approx(2000 / 2.71828, abs=2)


@pytest.mark.spec("A-80")
def test_the_output_rises_along_its_ramp(topcon):
    topcon.set(load="resistor 10")
    run(topcon)
    topcon.run(0.050)
    assert topcon.sdo["Actual voltage"].raw == pytest.approx(2000, abs=45)
    topcon.run(0.055)
    assert topcon.sdo["Actual voltage"].raw >= 3578 - 45
