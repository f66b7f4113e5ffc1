import pytest

from canopen_twins import Bench

from .bus import emcy, reset, run, state_of_output

NO_ERROR = "085#0000000000000000"


CAUSES = [  # fault, its parameters, what is told: code, register, details
    ("mains", {"volts": 339}, 0x3200, 0x05, [0x4D, 0x49]),
    ("mains", {"volts": 345}, 0x3200, 0x05, []),
    ("mains", {"volts": 461}, 0x3200, 0x05, [0x4D, 0x4A]),
    ("mains", {"volts": 300}, 0x3200, 0x05, [0x4D, 0x49]),
    ("supply", {"rail": "24V", "volts": 21.5}, 0x3200, 0x05, [0x4B]),
    ("supply", {"rail": "24V", "volts": 26.5}, 0x3200, 0x05, [0x4C]),
    ("supply", {"rail": "5V", "volts": 4.4}, 0x3200, 0x05, [0x43]),
    ("supply", {"rail": "5V", "volts": 5.6}, 0x3200, 0x05, [0x44]),
    ("supply", {"rail": "15V", "volts": 13.4}, 0x3200, 0x05, [0x45]),
    ("supply", {"rail": "15V", "volts": 16.6}, 0x3200, 0x05, [0x46]),
    ("supply", {"rail": "-15V", "volts": -13.4}, 0x3200, 0x05, [0x47]),
    ("supply", {"rail": "-15V", "volts": -16.6}, 0x3200, 0x05, [0x48]),
    ("supply", {"rail": "24V", "volts": 22}, 0x3200, 0x05, []),
    ("overtemperature", {"sensor": "rectifier"}, 0x4200, 0x09, [0x50]),
    ("overtemperature", {}, 0x4200, 0x09, [0x51]),
    ("overtemperature", {"sensor": "inside"}, 0x4200, 0x09, [0x55]),
    ("interlock_open", {}, 0x9000, 0x81, [0xF2]),
    ("sense_reversed", {}, 0x3300, 0x05, [0x33]),
    ("sense_offset", {"volts": 21}, 0x3300, 0x05, [0x31]),
    ("sense_offset", {"volts": -21}, 0x3300, 0x05, [0x31]),
    ("sense_offset", {"volts": 20}, 0x3300, 0x05, []),
    ("lasting_error", {"number": 0xF4}, 0xF000, 0x81, [0xF4]),  # safety relay
    ("lasting_error", {"number": 0xF7}, 0xF000, 0x81, [0xF7]),  # enable missing
    ("lasting_error", {"number": 0xC5}, 0x7000, 0x81, [0xC5]),  # incomplete frames of a slave
    ("lasting_error", {"number": 0x65}, 0x8100, 0x11, [0x65]),  # HMI unplugged
]


@pytest.mark.spec("T-193", "T-194", "A-63", "A-83")
@pytest.mark.parametrize(("fault", "parameters", "code", "register", "details"), CAUSES)
def test_a_cause_is_told_stops_the_output_and_can_be_reset_when_it_is_gone(
    topcon, fault, parameters, code, register, details
):
    run(topcon, voltage=2000)
    topcon.run(1.0)
    topcon.inject(fault, **parameters)
    topcon.run(0.1)
    told = [frame for frame in topcon.sent if frame.startswith("085")]
    assert sorted(told) == sorted(emcy(code, register, detail) for detail in details)
    assert state_of_output(topcon) & 0x8001 == (0x8000 if details else 0x0001)
    if details:
        assert reset(topcon) != NO_ERROR  # while the cause is there
        topcon.clear(fault)
        topcon.run(5.0)
        assert reset(topcon) == NO_ERROR
        assert state_of_output(topcon) & 0x8001 == 0


@pytest.mark.spec("A-83")
@pytest.mark.parametrize(
    ("feeding", "details"),
    [
        ({"hertz": 47.9}, [0x143]),
        ({"hertz": 62.1}, [0x142]),
        ({"volts": 335}, [0x145]),
        ({"volts": 470, "hertz": 63}, [0x144, 0x142]),
        ({"hertz": 48}, []),
    ],
)
def test_a_regenerative_unit_watches_voltage_and_frequency_of_the_mains(feeding, details):
    bench = Bench("topcon", node_id=5, unit="TCP-32-400-IBC")
    bench.inject("mains", **feeding)
    bench.run(0.1)
    told = [frame for frame in bench.sent if frame.startswith("085")]
    assert sorted(told) == sorted(emcy(0x3100, 0x05, detail) for detail in details)
    bench.clear("mains")
    assert (reset(bench) == NO_ERROR) is bool(details)


@pytest.mark.spec("T-193", "A-83")
def test_the_dc_link_is_low_only_after_20_ms(topcon):
    topcon.inject("mains", volts=339.9)
    topcon.run(0.019)
    assert emcy(0x3200, 0x05, 0x49) not in topcon.sent
    topcon.run(0.002)
    assert topcon.sent[-1] == emcy(0x3200, 0x05, 0x49)


@pytest.mark.spec("T-193", "A-83")
def test_mains_that_are_gone_at_once_are_a_jump_and_then_low(topcon):
    topcon.run(0.1)
    topcon.inject("mains", volts=330)
    assert topcon.run(0.019) == [emcy(0x3200, 0x05, 0x4D)]
    assert topcon.run(0.1) == [emcy(0x3200, 0x05, 0x49)]


@pytest.mark.spec("T-193", "A-83")
@pytest.mark.parametrize(("volts", "detail"), [(330, 0x49), (470, 0x4A)])
def test_mains_that_go_slowly_are_low_or_high_and_no_jump(topcon, volts, detail):
    topcon.inject("mains", volts=volts, seconds=0.5)
    topcon.run(0.4)
    assert emcy(0x3200, 0x05, detail) not in topcon.sent
    topcon.run(0.4)
    assert topcon.sent[-1] == emcy(0x3200, 0x05, detail)
    topcon.clear("mains")  # as slowly
    topcon.run(0.05)
    assert reset(topcon) != NO_ERROR
    topcon.run(0.5)
    assert reset(topcon) == NO_ERROR
    assert [frame for frame in topcon.sent if frame.startswith("085")] == [
        emcy(0x3200, 0x05, detail),
        NO_ERROR,
    ]


@pytest.mark.spec("A-53", "A-83")
@pytest.mark.parametrize(
    ("volts", "warned"), [(356, True), (358, False), (436, False), (438, True)]
)
def test_mains_near_a_limit_are_a_warning(topcon, volts, warned):
    topcon.inject("mains", volts=volts)
    topcon.run(0.1)
    assert state_of_output(topcon) == (0x4000 if warned else 0)


@pytest.mark.spec("T-193", "A-83")
@pytest.mark.parametrize(("volts", "detail"), [(339, 0x145), (461, 0x144)])
def test_a_regenerating_unit_watches_the_mains_itself(unit_file, volts, detail):
    bench = Bench("topcon", node_id=5, unit="MINE", unit_file=unit_file(regenerative=True))
    bench.inject("mains", volts=volts)
    assert bench.run(0.1) == [emcy(0x3100, 0x05, detail)]


@pytest.mark.spec("T-193", "A-47", "A-83")
def test_an_open_interlock_lets_nothing_start_and_nothing_be_reset(topcon):
    topcon.inject("interlock_open")
    assert topcon.run(0.001) == [emcy(0x9000, 0x81, 0xF2)]
    run(topcon, voltage=2000)
    assert state_of_output(topcon) == 0x8000
    reset(topcon)
    assert state_of_output(topcon) == 0x8000
    topcon.clear("interlock_open")
    assert reset(topcon) == NO_ERROR
    topcon.run(1.0)
    assert state_of_output(topcon) == 0
    topcon.sdo["Run command"].raw = 1
    assert state_of_output(topcon) == 0x0003


@pytest.mark.spec("A-76", "A-83")
def test_a_cause_outlives_a_power_cycle(topcon):
    topcon.inject("interlock_open")
    topcon.power_off()
    topcon.power_on()
    assert topcon.run(0.1) == [emcy(0x9000, 0x81, 0xF2)]
    topcon.clear()
    assert reset(topcon) == NO_ERROR


@pytest.mark.spec("A-76", "A-83")
def test_mains_that_are_low_at_power_on_have_not_jumped(topcon):
    topcon.inject("mains", volts=330)
    topcon.run(0.1)
    topcon.power_off()
    topcon.power_on()
    assert topcon.run(0.1) == [emcy(0x3200, 0x05, 0x49)]


@pytest.mark.spec("T-194", "A-74", "A-83")
@pytest.mark.parametrize(("connection", "count"), [("parallel", 0xD6), ("series", 0xD5)])
def test_a_slave_that_falls_silent_is_missing_at_the_reset(connection, count):
    bench = Bench("topcon", node_id=5, units=3, connection=connection)
    run(bench, voltage=2000)
    bench.run(1.0)
    bench.inject("slave_silent")
    assert bench.run(0.099) == []
    assert bench.run(0.002) == [emcy(0x8100, 0x11, 0x67)]
    assert state_of_output(bench) == 0x8000
    reset(bench)
    assert bench.sent[-2:] == [emcy(0x7000, 0x81, count), emcy(0x7000, 0x81, 0xDA)]
    bench.clear()
    assert reset(bench) == NO_ERROR
    bench.sdo["Run command"].raw = 1
    assert state_of_output(bench) == 0x0003


@pytest.mark.spec("T-194", "A-74")
def test_a_single_unit_has_no_slave_to_lose(topcon):
    topcon.inject("slave_silent")
    assert topcon.run(1.0) == []
