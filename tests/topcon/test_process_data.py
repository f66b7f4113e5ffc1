import pytest

from canopen_twins import Bench

from .bus import START, aborted, read, refused, run, state_of_output

A, B, EXAMPLE = "TCP-32-400", "TCP-16-100", "EXAMPLE-100-800-32"

POINTS = [  # unit, set values U I P Ri in parts, load, readings U I P in parts, state
    (A, (2000, 4000, 4000, 0), "open", (2000, 0, 0), 0x0003),
    (A, (4000, 2000, 4000, 0), "resistor 4 ohm", (2000, 2000, 1250), 0x0005),
    (A, (4000, 4000, 4000, 0), "resistor 4 ohm", (3578, 3578, 4000), 0x0009),
    (A, (4000, 1000, 4000, 0), "short", (1, 1000, 0), 0x0005),
    (A, (3000, 800, 4000, 0), "battery 350 V 0.1 ohm", (3500, -7, -8), 0x0003),
    (A, (2000, 1000, 4000, 0), "sink 30 A", (8, 1000, 3), 0x0005),
    (B, (2000, 4000, 4000, 800), "resistor 0.8 ohm", (1600, 1000, 500), 0x0003),
    (B, (4000, 4000, 2300, 0), "resistor 1 ohm", (3837, 1918, 2300), 0x0009),
    (EXAMPLE, (1340, 750, 1250, 0), "resistor 0.05 ohm", (300, 750, 141), 0x0005),
]


@pytest.mark.spec("T-180", "T-181", "T-182", "T-183", "A-52", "A-81")
@pytest.mark.parametrize(("unit", "parts", "load", "expected", "word"), POINTS)
def test_a_settled_output_reads_as_tabulated(unit, parts, load, expected, word):
    bench = Bench("topcon", unit=unit, load=load)
    run(bench, *parts)
    bench.run(3.0)
    actual = [bench.sdo[f"Actual {name}"].raw for name in ("voltage", "current", "power")]
    assert actual[:2] == [pytest.approx(value, abs=2) for value in expected[:2]]
    assert actual[2] == pytest.approx(expected[2], abs=4)
    assert state_of_output(bench) == word


@pytest.mark.spec("T-160", "A-44", "A-77")
@pytest.mark.parametrize(
    ("settings", "nominal"),
    [
        ({}, [400, 100, 32, 4000]),
        ({"unit": A}, [400, 100, 32, 4000]),
        ({"unit": B}, [100, 200, 16, 1000]),
        ({"unit": EXAMPLE}, [100, 800, 32, 1000]),
        ({"unit": A, "units": 2}, [400, 200, 64, 2000]),
        ({"unit": A, "units": 4, "connection": "parallel"}, [400, 400, 128, 1000]),
        ({"unit": A, "units": 2, "connection": "series"}, [800, 100, 64, 8000]),
    ],
)
def test_the_nominal_values_are_those_of_the_unit_or_the_system(settings, nominal):
    bench = Bench("topcon", **settings)
    assert [bench.sdo[index].raw for index in range(0x2000, 0x2004)] == nominal


@pytest.mark.spec("T-160")
@pytest.mark.parametrize("index", [*range(0x2000, 0x2004), *range(0x2020, 0x2024)])
def test_nominal_and_actual_values_cannot_be_written(topcon, index):
    with refused(0x06010002):
        topcon.sdo[index].raw = 1


@pytest.mark.spec("T-170", "T-171", "T-172", "T-173")
def test_the_four_examples_of_set_values_are_true_on_one_unit():
    bench = Bench("topcon", node_id=5, unit=EXAMPLE)
    for frame in ("2B1020003C05", "2B112000EE02", "2B122000E204", "2B1320002003"):
        assert aborted(bench.send(f"605#{frame}0000")) is None
    stage = bench.device.stage
    assert stage.voltage_reference == 33.5
    assert stage.current_reference == 150
    assert stage.power_reference == 10_000
    assert stage.resistance_reference == 0.2


@pytest.mark.spec("T-170", "T-181", "A-50")
def test_33_5_volt_set_are_33_5_volt_measured():
    bench = Bench("topcon", unit=EXAMPLE)
    run(bench, voltage=1340)
    bench.run(3.0)
    assert bench.device.report["voltage [V]"] == pytest.approx(33.5, abs=0.01)
    assert bench.sdo["Actual voltage"].raw == 1340


@pytest.mark.spec("T-181", "A-50")
@pytest.mark.parametrize(("volts", "parts"), [(41.5, 415), (415.0, 4150)])
def test_both_readings_of_the_example_of_0x2020_are_on_one_scale(volts, parts):
    bench = Bench("topcon", load=f"battery {volts} V 0.001 ohm")
    bench.run(3.0)
    assert bench.sdo["Actual voltage"].raw == parts


@pytest.mark.spec("T-182")
def test_the_example_of_0x2021(topcon):
    topcon.set(load="sink 98.025 A")
    run(topcon, voltage=1000)
    topcon.run(3.0)
    assert topcon.sdo["Actual current"].raw == 3921


@pytest.mark.spec("T-183")
def test_the_example_of_0x2022():
    bench = Bench("topcon", unit=B, load="resistor 1 ohm")
    run(bench, power=2300)
    bench.run(3.0)
    assert bench.sdo["Actual power"].raw == 2300
    assert bench.device.report["power [W]"] == pytest.approx(9200, abs=1)


@pytest.mark.spec("T-174", "A-40", "A-43")
@pytest.mark.parametrize("index", range(0x2010, 0x2014))
def test_set_values_go_from_0_to_4000(topcon, index):
    entry = topcon.sdo[index]
    for value in (0, 1, 2047, 3999, 4000):
        entry.raw = value
        assert entry.raw == value
    for value, code in ((4001, 0x06090031), (32767, 0x06090031), (-1, 0x06090032)):
        with refused(code):
            entry.raw = value
    assert entry.raw == 4000


@pytest.mark.spec("T-170", "A-40")
def test_every_set_value_reads_back_as_written(topcon):
    for value in range(4001):
        topcon.send(f"605#2B102000{value.to_bytes(2, 'little').hex()}0000")
        assert read(topcon, 0x2010)[0][12:16] == value.to_bytes(2, "little").hex().upper()


@pytest.mark.spec("T-185", "T-186", "A-54", "A-55")
@pytest.mark.parametrize("index", [0x2030, 0x2031])
def test_levels_go_from_0_to_4400(topcon, index):
    entry = topcon.sdo[index]
    for value in (0, 4000, 4200, 4400):
        entry.raw = value
        assert entry.raw == value
    for value in (4401, 65535):
        with refused(0x06090031):
            entry.raw = value
    assert entry.raw == 4400


@pytest.mark.spec("T-185")
def test_the_example_of_an_overvoltage_level():
    bench = Bench("topcon", units=2, connection="series")
    assert bench.sdo["Nominal voltage"].raw == 800
    bench.sdo["Overvoltage level"].raw = 4200
    assert bench.device.stage.overvoltage_level == pytest.approx(840)


@pytest.mark.spec("T-186")
def test_4000_parts_of_the_overcurrent_level_are_the_maximum_current(topcon):
    topcon.sdo["Overcurrent level"].raw = 4000
    assert topcon.device.stage.overcurrent_level == pytest.approx(100)


@pytest.mark.spec("T-180")
def test_the_output_reads_nothing_while_it_is_off(topcon):
    assert [topcon.sdo[index].raw for index in range(0x2020, 0x2024)] == [0, 0, 0, 0]


@pytest.mark.spec("A-42", "A-81")
def test_noise_free_rounding_is_half_away_from_zero(topcon):
    quantity = topcon.device.scale.voltage
    volts = {0.05: 1, 0.049: 0, -0.05: -1, -0.049: 0, 400: 4000, 1e6: 32767, -1e6: -32768}
    assert {value: quantity.parts(value) for value in volts} == volts


@pytest.mark.spec("A-58", "T-121")
def test_set_values_follow_at_once_while_the_output_is_on(topcon):
    topcon.send(START)
    topcon.set(load="resistor 10")
    run(topcon, voltage=1000)
    topcon.run(1.0)
    topcon.send("205#D007")
    topcon.run(0.1)
    assert topcon.sdo["Actual voltage"].raw == 2000
    topcon.send("305#9001")  # 10 A
    topcon.run(0.1)
    assert topcon.sdo["Actual current"].raw == 400
    assert state_of_output(topcon) == 0x0005
