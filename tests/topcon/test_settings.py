import pytest

from canopen_twins import Bench

from .bus import ENTER_PREOP, RESET_COMMUNICATION, START, STOP, refused, run, state_of_output

TRIP = {"number": 0x23}


@pytest.mark.spec("A-14")
@pytest.mark.parametrize(
    ("settings", "answer"),
    [
        ({}, "585#4303100300000000"),
        ({"empty_1003": "zero"}, "585#4303100300000000"),
        ({"empty_1003": "abort"}, "585#8003100324000008"),
    ],
)
def test_an_unused_entry_of_the_error_history(settings, answer):
    bench = Bench("topcon", node_id=5, **settings)
    bench.inject("error", **TRIP)
    assert bench.send("605#4003100300000000") == [answer]
    assert bench.send("605#4003100100000000") == ["585#4303100100232300"]


@pytest.mark.spec("A-18", "A-19", "A-24", "A-75")
def test_the_names_and_numbers_of_the_delivered_unit(topcon):
    assert topcon.sdo["Manufacturer Hardware Version"].raw == "V4.x"
    assert topcon.sdo["Manufacturer Software Version"].raw == "V4.11.45"
    assert topcon.sdo["Identity Object"]["Revision number"].raw == 0x00000009
    assert topcon.sdo["Identity Object"]["Serial number"].raw == 1


@pytest.mark.spec("A-18", "A-19", "A-24", "A-75")
def test_another_unit_has_other_names_and_numbers():
    bench = Bench("topcon", hardware_version="V5.0", firmware="V4.20.17", serial=0xFFFFFFFF)
    assert bench.sdo["Manufacturer Hardware Version"].raw == "V5.0"
    assert bench.sdo["Manufacturer Software Version"].raw == "V4.20.17"
    assert bench.sdo["Identity Object"]["Serial number"].raw == 0xFFFFFFFF


@pytest.mark.spec("A-23")
@pytest.mark.parametrize(
    ("settings", "at_once"),
    [({}, []), ({"hb_first": "period"}, []), ({"hb_first": "now"}, ["705#7F"])],
)
def test_the_first_heartbeat_comes_a_period_later_or_at_once(settings, at_once):
    bench = Bench("topcon", node_id=5, **settings)
    assert bench.send("605#2B171000E8030000") == [*at_once, "585#6017100000000000"]
    assert bench.run(0.999) == []
    assert bench.run(0.001) == ["705#7F"]


@pytest.mark.spec("A-40")
@pytest.mark.parametrize(
    ("settings", "highest"),
    [
        ({}, 4000),
        ({"set_value_range": 4400}, 4400),
        ({"set_value_range": 100, "power_on_power": 100}, 100),
    ],
)
@pytest.mark.parametrize("name", ["Voltage", "Current", "Power", "Internal resistance"])
def test_how_high_a_set_value_may_be(settings, highest, name):
    bench = Bench("topcon", node_id=5, **settings)
    entry = bench.sdo[f"{name} reference"]
    entry.raw = highest
    with refused(0x06090031):
        entry.raw = highest + 1
    with refused(0x06090032):
        entry.raw = -1
    assert entry.raw == highest


@pytest.mark.spec("A-42")
def test_set_values_nobody_has_set(topcon):
    read = [topcon.sdo[index].raw for index in (0x2010, 0x2011, 0x2012, 0x2013, 0x2030, 0x2031)]
    assert read == [0, 0, 4000, 0, 4400, 4400]


@pytest.mark.spec("A-42")
@pytest.mark.parametrize(
    ("name", "index"),
    [
        ("power_on_voltage", 0x2010),
        ("power_on_current", 0x2011),
        ("power_on_power", 0x2012),
        ("power_on_resistance", 0x2013),
        ("power_on_overvoltage", 0x2030),
        ("power_on_overcurrent", 0x2031),
    ],
)
def test_set_values_at_power_on_can_be_chosen(name, index):
    bench = Bench("topcon", **{name: 1234})
    assert bench.sdo[index].raw == 1234


@pytest.mark.spec("A-47")
@pytest.mark.parametrize(
    ("settings", "answer", "emcy", "command"),
    [
        ({}, "585#6014200000000000", [], 1),
        ({"run_while_error": "ignore"}, "585#6014200000000000", [], 1),
        ({"run_while_error": "abort"}, "585#8014200022000008", [], 0),
        ({"run_while_error": "emcy"}, "585#6014200000000000", ["085#0061837A00000000"], 1),
    ],
)
def test_run_while_an_error_is_active(settings, answer, emcy, command):
    bench = Bench("topcon", node_id=5, **settings)
    bench.inject("error", **TRIP)
    assert bench.send("605#2B14200001000000") == [answer, *emcy]
    assert bench.sdo["Run command"].raw == command
    assert state_of_output(bench) == 0x8000
    assert bench.send("605#2B14200001000000") == [answer]  # an error is told once


@pytest.mark.spec("A-47")
def test_a_refused_run_by_pdo_is_no_parameter_out_of_its_limits():
    bench = Bench("topcon", node_id=5, run_while_error="abort")
    bench.inject("error", **TRIP)
    bench.send(START)
    assert bench.send("505#0100") == []


@pytest.mark.spec("A-57")
@pytest.mark.parametrize(
    ("settings", "word", "frames"),
    [
        ({}, 0x8000, ["085#0033053000000000"]),
        ({"ovp_when_off": True}, 0x8000, ["085#0033053000000000"]),
        ({"ovp_when_off": False}, 0x0000, []),
    ],
)
def test_a_battery_above_the_level_with_the_output_off(settings, word, frames):
    bench = Bench("topcon", node_id=5, load="battery 460 0.1", **settings)
    assert bench.run(0.1) == frames
    assert state_of_output(bench) == word


@pytest.mark.spec("A-58")
@pytest.mark.parametrize(
    ("settings", "word"),
    [
        ({}, 0x0003),
        ({"on_leave_operational": "keep"}, 0x0003),
        ({"on_leave_operational": "stop"}, 0),
    ],
)
@pytest.mark.parametrize("command", [ENTER_PREOP, STOP, RESET_COMMUNICATION])
def test_the_output_when_the_node_leaves_operational(settings, word, command):
    bench = Bench("topcon", node_id=5, **settings)
    bench.send(START)
    run(bench, voltage=2000)
    bench.run(1.0)
    bench.send(command)
    bench.send(ENTER_PREOP)
    assert state_of_output(bench) == word


@pytest.mark.spec("A-58")
def test_entering_operational_stops_nothing():
    bench = Bench("topcon", node_id=5, on_leave_operational="stop")
    run(bench, voltage=2000)
    bench.run(1.0)
    bench.send(START)
    assert state_of_output(bench) == 0x0003
