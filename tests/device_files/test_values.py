"""Values that move as a device file says, on the clock of a bench."""

from itertools import pairwise
from math import exp, inf

import pytest

from canopen_twins import Bench
from canopen_twins.devices.eds.model import Follower, Integral, Kind, Ramp, constant, rest, step


def value(bench, name):
    return bench.values(name)[name]


def course(bench, name, times, dt):
    """What a value is at each of so many moments, dt seconds apart."""
    seen = []
    for _ in range(times):
        bench.run(dt)
        seen.append(value(bench, name))
    return seen


def test_a_value_follows_with_its_time_constant(bench):
    twin = bench("values: {Temperature: {follows: 1000, time_constant: 10, from: 0}}")
    assert course(twin, "Temperature", 3, 10) == [round(1000 * (1 - exp(-n))) for n in (1, 2, 3)]


def test_without_a_time_constant_it_follows_in_the_next_cycle(bench):
    twin = bench("values: {Voltage: {follows: Operating time, gain: 2, offset: 5}}")
    assert value(twin, "Voltage") == 5
    twin.sdo["Operating time"].raw = 100
    assert value(twin, "Voltage") == 5
    twin.run(0.01)
    assert value(twin, "Voltage") == 205


def test_a_ramp_goes_evenly_and_stays(bench):
    twin = bench("values: {Current: {ramps: -100, rate: 10}}")
    assert course(twin, "Current", 12, 1) == [*range(-10, -101, -10), -100, -100]


def test_an_integral_grows_by_what_another_value_is_and_stops_at_its_ends(bench):
    twin = bench(
        "values:\n  Current: {value: -36}\n"
        "  Charge: {integrates: Current, gain: 0.5, from: 40, low: 0, high: 60}"
    )
    assert course(twin, "Charge", 4, 1) == [22, 4, 0, 0]
    twin.set(Current=24)
    assert course(twin, "Charge", 6, 1) == [12, 24, 36, 48, 60, 60]


def test_a_counter_begins_anew_behind_its_highest_number(bench):
    twin = bench("values: {Voltage: {counts: 2, every: 0.5, from: 5, low: 1, high: 8}}")
    assert course(twin, "Voltage", 5, 0.5) == [7, 1, 3, 5, 7]


def test_a_counter_wraps_at_the_end_of_its_type(bench):
    twin = bench("values: {Voltage: {counts: 1, from: 65534}}")
    assert course(twin, "Voltage", 3, 1) == [65535, 0, 1]


def test_what_wanders_stays_between_its_ends(bench):
    twin = bench("values: {Temperature: {wanders: 9, every: 0.1, low: -10, high: 10}}")
    seen = course(twin, "Temperature", 200, 0.1)
    assert min(seen) < -5
    assert max(seen) > 5
    assert all(-10 <= each <= 10 for each in seen)
    assert all(abs(b - a) <= 10 for a, b in pairwise(seen))


def test_noise_is_around_its_value_and_another_one_every_so_often(bench):
    twin = bench("values: {Voltage: {value: 48000, noise: 20, every: 0.5}}")
    seen = course(twin, "Voltage", 100, 0.25)
    assert {abs(each - 48000) <= 20 for each in seen} == {True}
    assert len(set(seen)) > 20
    assert all(a == b for a, b in zip(seen[1::2], seen[2::2], strict=False))


def test_a_file_of_samples_is_replayed_each_from_its_time_on(bench, tmp_path):
    (tmp_path / "day.csv").write_text("0.5,7\n1,8\n2.5,9\n")
    twin = bench("values: {Voltage: {replays: day.csv}}")
    assert value(twin, "Voltage") == 0
    assert course(twin, "Voltage", 7, 0.5) == [7, 8, 8, 8, 9, 9, 9]


def test_samples_begin_anew_with_the_time_of_the_last_one(bench, tmp_path):
    (tmp_path / "day.csv").write_text("time;x\n".replace(";", ",") + "0,1\n1,2\n3,1\n")
    twin = bench("values: {Voltage: {replays: day.csv, column: x, repeat: true}}")
    assert course(twin, "Voltage", 7, 1) == [2, 2, 1, 2, 2, 1, 2]


def test_a_number_may_be_a_setting_which_may_change(bench):
    twin = bench(
        "settings: {pace: {default: 10, low: 1, high: 50}}\n"
        "values: {Current: {ramps: 1000, rate: pace}}",
        pace=20,
    )
    assert course(twin, "Current", 2, 1) == [20, 40]
    twin.set(pace=5)
    assert course(twin, "Current", 2, 1) == [45, 50]


@pytest.mark.parametrize("seed", [1, 2])
def test_the_same_seed_the_same_trace(bench, seed):
    text = (
        "values:\n  Voltage: {value: 48000, noise: 20, every: 0.1}\n"
        "  Current: {wanders: 100, every: 0.1, low: -1000, high: 1000}"
    )

    def trace(seed):
        twin = bench(text, seed=seed)
        twin.send("000#0105")
        twin.run(5)
        return [str(record) for record in twin.trace]

    assert trace(seed) == trace(seed)
    assert trace(seed) != trace(seed + 1)


def test_a_change_is_sent_with_an_event_driven_pdo(bench):
    twin = bench("values: {Voltage: {counts: 1, every: 0.2}}")
    assert twin.send("000#0105") == ["185#000000000000"]
    assert twin.run(0.45) == ["185#010000000000", "185#020000000000"]


def test_what_a_master_writes_is_where_a_value_moves_on_from(bench):
    twin = bench("values: {Operating time: {counts: 1}}")
    twin.run(3)
    twin.sdo["Operating time"].raw = 1000
    twin.run(2)
    assert twin.sdo["Operating time"].raw == 1002


def test_a_reset_of_the_node_is_none_of_what_it_measures(bench):
    twin = bench("values:\n  Operating time: {counts: 1}\n  Voltage: {counts: 1}")
    twin.run(3)
    twin.send("000#8105")
    assert twin.values("Operating time", "Voltage") == {"Operating time": 0, "Voltage": 3}


def test_power_on_begins_anew(bench):
    twin = bench("values: {Voltage: {counts: 1}}")
    twin.run(3)
    twin.power_off()
    twin.power_on()
    assert value(twin, "Voltage") == 0


def test_a_value_that_has_no_room_stays_at_the_end_of_its_type(bench):
    twin = bench("values: {Temperature: {ramps: 100000, rate: 50000}}")
    assert course(twin, "Temperature", 2, 1) == [32767, 32767]


def test_a_report_has_values_with_their_units(bench):
    twin = bench("values: {Voltage: {value: 48000, unit: mV}, Charge: {value: 7}}")
    assert twin.report == {"Voltage [mV]": 48000, "Charge": 7}


def test_a_chart_has_a_curve_for_each_value_beside_what_it_goes_to(bench):
    twin = bench("values: {Temperature: {follows: 80, time_constant: 5, from: 20, unit: degC}}")
    (curve,) = twin.device.chart.curves
    assert (curve.label, curve.unit) == ("Temperature", "degC")
    assert (curve.actual(), curve.wanted()) == (20, 80)


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("values: {Voltage: {value: 48000}}", inf),
        ("values: {Voltage: {follows: Operating time}}", inf),
        ("values: {Voltage: {counts: 1, every: 60}}", 60),
        ("values: {Voltage: {value: 5, noise: 1, every: 2}}", 2),
        ("values: {Current: {ramps: 100, rate: 1}}", 0.5),
        ("values: {Charge: {integrates: 0.01}}", 50),
        ("values: {State of charge: {integrates: 0.01}}", 0),
    ],
)
def test_it_rests_as_long_as_nothing_is_to_be_seen(bench, text, seconds):
    assert bench(text).device.rest == seconds


class Counted(Follower):
    steps = 0

    def step(self, dt):
        self.steps += 1
        super().step(dt)


def test_what_rests_is_not_stepped(bench):
    twin = bench("values: {Voltage: {follows: Operating time}}")
    counted = Counted(0.0, Kind(whole=True), constant(0.0), constant(0.0))
    twin.device._quantities = {(0x2001, 0): counted}
    twin.run(3600)
    assert counted.steps == 0


def quantities():
    """A follower behind a ramp, and the sum of both, as whole numbers."""
    whole = Kind(whole=True)
    ramp = Ramp(0.0, whole, constant(500.0), constant(7.0))
    follower = Follower(0.0, whole, lambda: ramp.reading, constant(3.0))
    total = Integral(0.0, whole, lambda: follower.reading, constant(0.0), constant(1e9))
    return ramp, follower, total


def test_sleeping_until_something_is_seen_changes_nothing_that_is_seen():
    every, seldom = quantities(), quantities()
    slept = 0
    for cycle in range(1, 20_000):
        step(every, 0.01)
        slept += 1
        if rest(seldom) < (slept + 1) * 0.01 - 1e-9 or cycle % 777 == 0:
            step(seldom, slept * 0.01)
            slept = 0
        assert [each.reading for each in seldom] == pytest.approx(
            [each.reading for each in every], abs=1
        )


def test_one_file_is_several_twins(write):
    path = str(write("values: {Voltage: {counts: 1}}"))
    bench = Bench.of({"left": (path, 5), "right": (path, 6)})
    bench.run(2)
    bench["left"].set(Voltage=50)
    bench.run(1)
    assert [bench[name].values("Voltage")["Voltage"] for name in ("left", "right")] == [51, 3]
