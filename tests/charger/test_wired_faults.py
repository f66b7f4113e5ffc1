import pytest
from charger_bus import CANOPEN, put, release, status, value

from canopen_twins import Bench, UserError


@pytest.mark.spec("C-163", "C-164", "A-54", "A-66")
def test_a_short_is_limited_warned_of_and_switched_off(on):
    on.inject("short")
    on.run(0.5)
    assert [value(on, sub, 0x6401) for sub in (1, 2, 4)] == [0, 5000, 0x203]
    assert on.run(1.0) == ["0E3#002303010A000000", "0E3#0023030509000000"]
    assert status(on) == 0x06


@pytest.mark.spec("C-181", "A-51")
def test_an_open_electrode_draws_no_current(on):
    on.inject("open_electrode")
    on.run(2.0)
    assert [value(on, sub, 0x6401) for sub in (1, 2)] == [20_000, 0]
    assert value(on, 0x0C, 0x2001) == 0xFFFFFFFF
    on.clear("open_electrode")
    on.run(2.0)
    assert value(on, 0x0C, 0x2001) == 10_000_000


def test_two_disturbances_of_one_thing_and_the_setting_under_them(on):
    on.inject("short")
    on.inject("open_electrode")
    on.set(load="resistor 20e6")
    currents = []
    for name in ("open_electrode", "short"):
        on.run(0.1)
        currents.append(value(on, 2, 0x6401))
        on.clear(name)
    on.run(0.1)
    assert [*currents, value(on, 2, 0x6401)] == [0, 5000, 1000]


@pytest.mark.spec("C-182")
@pytest.mark.parametrize(
    ("volts", "frames"),
    [
        (19.5, ["0E3#0031050501000000"]),
        (17.5, ["0E3#0031050501000000", "0E3#0031050101000000"]),
        (29.0, ["0E3#0031050502000000"]),
        (31.0, ["0E3#0031050502000000", "0E3#0031050102000000"]),
    ],
)
def test_a_supply_out_of_its_range_is_told(quiet, volts, frames):
    quiet.inject("supply", volts=volts)
    assert quiet.run(1.0) == frames
    assert abs(value(quiet, 1, 0x2001) - 1000 * volts) < 30


@pytest.mark.spec("C-183", "C-143")
@pytest.mark.parametrize(
    ("sensor", "kelvin", "number"), [("power_stage", 50, 3), ("inside", 35, 4), ("cascade", 45, 5)]
)
def test_overtemperature_warns_at_its_sensor(quiet, sensor, kelvin, number):
    quiet.inject("overtemperature", sensor=sensor, kelvin=kelvin)
    assert quiet.run(0.1) == [f"0E3#00420905{number:02X}000000"]


@pytest.mark.spec("C-183", "C-045")
def test_overtemperature_can_be_cleared_when_it_has_cooled_down(quiet):
    quiet.inject("overtemperature")
    assert quiet.run(0.1) == ["0E3#0042090503000000", "0E3#0042090104000000"]
    put(quiet, {1: 4}, index=0x2003)
    assert status(quiet) == 0x06
    quiet.clear()
    quiet.run(0.1)
    put(quiet, {1: 4, 2: 3}, index=0x2003)
    assert (status(quiet), quiet.sdo[0x1001].raw) == (0x00, 0x00)


@pytest.mark.spec("C-191", "C-190")
def test_the_sensor_of_the_discharging_is_that_of_an_a():
    bench = Bench("charger", variant="A", heartbeat_default_ms=0)
    bench.inject("overtemperature", sensor="discharging", kelvin=50)
    assert bench.run(0.1) == ["0E3#004209050E000000"]
    assert value(bench, 0x0D, 0x2001) == 75


@pytest.mark.spec("C-173", "C-175")
def test_a_storm_is_random_and_the_same_for_the_same_seed():
    def counts(seed):
        bench = Bench("charger")
        put(bench, {0x18: 0})
        release(bench)
        bench.inject("spark_storm", rate=5, seed=seed)
        bench.run(30.0)
        bench.set(ambient=26)  # which is no new storm
        bench.run(30.0)
        return [value(bench, sub, 0x2001) for sub in range(0x08, 0x0C)]

    assert counts(1) == counts(1) != counts(2)
    assert 150 < sum(counts(1)) < 300


@pytest.mark.spec("C-173")
def test_a_storm_may_depend_on_the_voltage():
    bench = Bench("charger")
    put(bench, {0x18: 0})
    release(bench)
    bench.inject("spark_storm", rate=5, breakdown=30_000, scale=1000)
    bench.run(60.0)
    assert [value(bench, sub, 0x2001) for sub in range(0x08, 0x0C)] == [0, 0, 0, 0]


@pytest.mark.spec("C-030", "A-37")
@pytest.mark.parametrize(
    ("fault", "given", "frame"),
    [
        ("error", {"key": "hardware"}, "0E3#005001010B000000"),
        ("error", {"number": 0x0B}, "0E3#005001010B000000"),
        ("error", {"number": 0x33, "code": 0x5112}, "0E3#1251010133000000"),
        ("error", {"number": 0x0B, "code": 0x8130}, "0E3#308111010B000000"),
        ("error", {"number": 0x50, "code": 0xFF01}, "0E3#01FF810150000000"),
        ("warning", {"number": 0x60, "code": 0x2340}, "0E3#4023030560000000"),
        ("warning", {"number": 1, "code": 0x3111}, "0E3#1131050501000000"),
        ("warning", {"number": 2, "code": 0x4211}, "0E3#1142090502000000"),
    ],
)
def test_any_message_by_key_by_number_or_with_a_code_of_its_own(bench, fault, given, frame):
    bench.inject(fault, **given)
    assert bench.sent[-1] == frame


@pytest.mark.parametrize(
    ("fault", "given", "told"),
    [
        ("error", {"key": "hardwear"}, "unknown error 'hardwear': did you mean 'hardware'?"),
        ("warning", {"key": "hardware"}, "unknown warning 'hardware'"),
        ("error", {}, "no error like this: number 0x00 is not in 0x01..0x50"),
        ("error", {"number": 0x51, "code": 0x5000}, "number 0x51 is not in 0x01..0x50"),
        ("error", {"number": 0x40}, "emcy 0x0000 is not in 0x1000..0xffff"),
        ("error", {"number": 0x40, "code": 0xFFF}, "emcy 0x0fff is not in 0x1000..0xffff"),
        ("spark", {"slope": -1}, "a slope and a rise time of 0 or more"),
        ("spark", {}, "fault 'spark' wants 'slope'"),
        ("spark_storm", {"rate": -1}, "a rate and a scale of 0 or more"),
        ("supply", {"volts": 5}, "a supply of 5.0 V: 6..40 V"),
        ("analog", {"percent": 101}, "'analog': 101 is more than 100"),
        ("insulating_pollution", {"percent": -1}, "-1.0 % is not in 0..100"),
        ("conductive_pollution", {"megaohm": 0}, "megaohm is above 0, not 0.0"),
        ("discharging_pollution", {"connector": 3}, "connected to 1 and 2, not to 3"),
        ("overtemperature", {"sensor": "cascades"}, "unknown sensor 'cascades'"),
        ("hmi_on", {"at": "door"}, "unknown place 'door'"),
    ],
)
def test_what_cannot_happen_is_refused_in_words(bench, fault, given, told):
    with pytest.raises(UserError) as refusal:
        bench.inject(fault, **given)
    assert told in str(refusal.value)
    assert not bench.twin.node.faults.active
    bench.run(1.0)


@pytest.mark.spec("C-143", "A-48")
def test_a_cause_outlives_a_power_cycle(quiet):
    for name, given in (("error", {"key": "hardware"}), ("hardware_release_lost", {})):
        quiet.inject(name, **given)
    quiet.power_off()
    quiet.power_on()
    assert quiet.sent[-2:] == ["763#00", "0E3#005001010B000000"]
    quiet.clear("error")
    put(quiet, {1: 0x0B}, index=0x2003)
    put(quiet, {0x02: CANOPEN})
    quiet.sdo[0x6200][1].raw = 0x0F
    assert status(quiet) == 0x20


@pytest.mark.parametrize("rise_time", [0, 8])
def test_sparks_without_high_voltage_are_none(bench, rise_time):
    bench.inject("spark", slope=1.0, rise_time=rise_time)
    assert value(bench, 0x08, 0x2001) == 0
