import pytest
from charger_bus import put, release, value

from canopen_twins import Bench, devices


@pytest.mark.spec("C-162", "C-165", "C-181", "C-182", "C-183", "A-65")
def test_20_kv_on_its_own_bar(on):
    on.run(1.0)
    assert [value(on, sub, 0x6401) for sub in range(1, 9)] == [20_000, 2000, 400, 3, 0, 0, 0, 0]
    assert [value(on, sub, 0x6000) for sub in range(1, 9)] == [0x29, 67, 40, 40, 0, 0, 0, 0]
    assert [value(on, sub, 0x2001) for sub in range(1, 5)] == [23_885, 2303, 550, 39]
    assert [value(on, sub, 0x2001) for sub in range(5, 8)] == [25, 25, 25]
    assert value(on, 0x0C, 0x2001) == 10_000_000
    assert [value(on, sub, 0x2001) for sub in (0x0F, 0x10)] == [0, 0]


@pytest.mark.spec("C-162", "C-156")
def test_the_mode_is_beside_its_limiter(quiet):
    release(quiet)
    seen = []
    for mode, voltage, current in ((3, 20_000, 5000), (3, 20_000, 1000), (4, 5000, 1000)):
        put(quiet, {0x10: mode, 0x08: voltage, 0x09: current})
        quiet.run(1.0)
        seen.append(value(quiet, 4, 0x6401))
    assert seen == [0x003, 0x203, 0x104]


@pytest.mark.spec("C-183", "A-65")
def test_temperatures_are_whole_degrees_that_saturate(on):
    on.run(3600.0)
    assert [value(on, sub, 0x2001) for sub in (5, 6, 7)] == [42, 33, 36]
    on.set(ambient=-40)
    on.run(36_000.0)
    assert [value(on, sub, 0x2001) for sub in (5, 6, 7)] == [0, 0, 0]
    on.inject("overtemperature", kelvin=400)
    on.run(0.1)
    assert value(on, 5, 0x2001) == 255


@pytest.mark.spec("C-173", "C-175")
def test_a_spark_is_counted_by_its_steepness(on):
    for slope, counts in (
        (0.125, [0, 0, 0, 0]),
        (0.13, [0, 0, 0, 1]),
        (0.17, [0, 0, 1, 1]),
        (0.21, [0, 1, 1, 1]),
        (0.26, [1, 1, 1, 1]),
    ):
        on.inject("spark", slope=slope)
        on.run(0.1)
        assert [value(on, sub, 0x2001) for sub in range(0x08, 0x0C)] == counts
    on.inject("spark", slope=0.26, rise_time=16)  # steep for twice the time
    assert value(on, 0x08, 0x2001) == 2


@pytest.mark.spec("C-174", "C-173", "C-036", "A-58", "A-59")
def test_ten_strong_sparks_switch_off_and_the_clear_starts_afresh(on):
    for _ in range(9):
        on.inject("spark", slope=0.26)
        on.run(0.1)
    assert value(on, 1, 0x6000) == 0x29
    on.inject("spark", slope=0.26)
    assert on.run(0.1) == ["0E3#0023030107000000"]
    assert value(on, 1, 0x6000) == 0x02
    assert value(on, 0x08, 0x2001) == 10
    put(on, {1: 7}, index=0x2003)
    assert "0E3#0000000107000000" in on.sent
    assert value(on, 0x08, 0x2001) == 0


@pytest.mark.spec("C-184", "C-185", "A-17")
@pytest.mark.parametrize("variant", ["A", "C"])
def test_hours_of_supply_charging_and_discharging(variant):
    device = devices.create("charger", variant=variant)
    year = 365 * 24 * 3600 * 100  # ticks of 10 ms
    device.memory.store("hours", {"operating": 2 * year, "charging": year - 6000})
    bench = Bench.of({"charger": device})
    if variant == "A":
        put(bench, {0x22: 1, 0x27: 0})
    bench.run(3600.0)
    release(bench)
    bench.run(60.0)
    read = [value(bench, sub, 0x2000) for sub in range(1, 13)]
    assert read == [2, 0, 1, 1, 1, 0, 0, 0, 0, 0, 1, 1]


@pytest.mark.spec("C-152", "A-50")
def test_the_power_setpoint_is_what_the_charger_allows_itself(on):
    assert value(on, 0x0A) == 100
    on.inject("supply", volts=20)
    on.run(5.0)
    assert 55 < value(on, 0x0A) < 70


@pytest.mark.spec("C-193", "C-194", "C-196", "C-200", "C-201", "C-190")
def test_the_values_of_the_discharging():
    bench = Bench("charger", variant="A", web_speed=2.0)
    put(bench, {0x22: 1, 0x27: 0})
    bench.run(0.1)
    assert [value(bench, sub, 0x6401) for sub in (5, 6, 7, 8)] == [5000, 942, -15, 2]
    assert [value(bench, sub, 0x2001) for sub in (0x0D, 0x0E, 0x0F, 0x10)] == [25, 1, 118, 118]
    assert [value(bench, sub) for sub in (0x1F, 0x20)] == [3000, 5]
    assert value(bench, 6, 0x6000) == 31
    put(bench, {0x26: 8, 0x25: 100})
    bench.run(0.1)
    assert value(bench, 0x0E, 0x2001) == 0x101
    assert value(bench, 6, 0x6401) <= 3000
    assert value(bench, 7, 0x6401) > 0
    bench.set(web_speed=100_000.0)
    bench.run(0.1)
    assert value(bench, 7, 0x6401) == -32_768


@pytest.mark.spec("C-192", "C-198", "C-199", "A-70")
@pytest.mark.parametrize(("connector", "percent", "dirt"), [(1, 200, [1, 0]), (2, 40, [0, 2])])
def test_a_dirty_discharging_bar_is_found(connector, percent, dirt):
    bench = Bench("charger", variant="C", heartbeat_default_ms=0)
    put(bench, {0x29: 118, 0x2A: 118})
    bench.run(0.1)
    assert [value(bench, sub, 0x6000) for sub in (7, 8)] == [0, 0]
    bench.inject("discharging_pollution", connector=connector, percent=percent)
    (told,) = bench.run(0.1)
    assert told == f"0E3#009001050{'CD'[connector - 1]}000000"
    assert [value(bench, sub, 0x6000) for sub in (7, 8)] == dirt


@pytest.mark.spec("C-179", "C-180", "C-181", "A-61")
@pytest.mark.parametrize(
    ("fault", "given"), [("conductive_pollution", {"megaohm": 8}), ("insulating_pollution", {})]
)
def test_a_dirty_charging_bar_is_told_at_50_percent(on, fault, given):
    put(on, {0x1A: 10_000_000, 0x19: 1})
    on.run(2.0)
    assert value(on, 5, 0x6000) == 0
    on.inject(fault, **given)
    on.run(2.0)
    assert value(on, 5, 0x6000) >= 50
    assert on.run(10.0) == ["0E3#009001050B000000"]
