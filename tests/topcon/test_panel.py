import logging

import pytest

from canopen_twins import Bench

from .bus import (
    ENTER_PREOP,
    RESET_COMMUNICATION,
    RESET_NODE,
    START,
    STOP,
    read,
    run,
    state_of_output,
)

SETTINGS = [  # a write from the bus, and where it goes
    ("605#2B102000E8030000", (0x2010,)),
    ("605#2B112000E8030000", (0x2011,)),
    ("605#2B122000E8030000", (0x2012,)),
    ("605#2B132000E8030000", (0x2013,)),
    ("605#2B14200001000000", (0x2014,)),
    ("605#2B302000E8030000", (0x2030,)),
    ("605#2B312000E8030000", (0x2031,)),
    ("605#2B002102E8030000", (0x2100, 2)),
]


def in_control(bench):
    return bench.device.report["control"]


@pytest.fixture
def local(topcon):
    """A TopCon whose panel has just been turned to local control."""
    topcon.set(panel="local")
    assert in_control(topcon) == "panel"
    return topcon


@pytest.mark.spec("T-080")
def test_the_panel_is_remote_after_power_on(local):
    local.power_off()
    local.power_on()
    assert in_control(local) == "bus"


@pytest.mark.spec("T-081", "T-082", "A-88")
@pytest.mark.parametrize("reset", [RESET_NODE, RESET_COMMUNICATION])
@pytest.mark.parametrize("local_write", ["ignore", "abort"])
def test_no_reset_by_the_master_takes_control_from_an_operator(reset, local_write):
    bench = Bench("topcon", node_id=5, local_write=local_write)
    run(bench, voltage=2000)
    bench.send("605#2310100173617665")  # save
    bench.sdo["Voltage reference"].raw = 1000
    bench.run(1.0)
    bench.set(panel="local")
    assert bench.send(reset) == ["705#00"]
    bench.run(1.0)
    assert in_control(bench) == "panel"
    assert state_of_output(bench) == 0x0003
    assert bench.sdo["Voltage reference"].raw == 1000
    assert bench.sdo["Actual voltage"].raw == 1000
    bench.send(START)
    assert in_control(bench) == "bus"


@pytest.mark.spec("A-58", "A-88")
def test_a_reset_of_the_node_takes_the_output_from_a_master_who_is_in_control(topcon):
    run(topcon, voltage=2000)
    topcon.set(panel="local")
    topcon.set(panel="remote")
    topcon.send(RESET_NODE)
    assert state_of_output(topcon) == 0
    assert topcon.sdo["Voltage reference"].raw == 0


@pytest.mark.spec("T-080")
def test_the_panel_is_remote_after_power_on_whatever_it_was_turned_to():
    assert in_control(Bench("topcon", panel="local")) == "bus"


@pytest.mark.spec("T-081")
@pytest.mark.parametrize("command", [ENTER_PREOP, STOP])
def test_outside_operational_the_panel_can_go_local_and_back(topcon, command):
    topcon.send(START)
    topcon.send(command)
    topcon.set(panel="local")
    assert in_control(topcon) == "panel"
    topcon.set(panel="remote")
    assert in_control(topcon) == "bus"


@pytest.mark.spec("T-081", "A-08")
@pytest.mark.parametrize(("write", "address"), SETTINGS)
def test_a_setting_is_confirmed_and_dropped_while_the_panel_is_local(local, write, address, caplog):
    before = read(local, *address)
    with caplog.at_level(logging.WARNING):
        assert local.send(write) == [f"585#60{write[6:12]}00000000"]
    assert "is ignored: the panel is in control" in caplog.text
    assert read(local, *address) == before


@pytest.mark.spec("T-081", "A-08")
@pytest.mark.parametrize(("write", "address"), SETTINGS)
def test_a_setting_may_be_refused_instead(write, address):
    bench = Bench("topcon", node_id=5, local_write="abort")
    bench.set(panel="local")
    before = read(bench, *address)
    assert bench.send(write) == [f"585#80{write[6:12]}21000008"]
    assert read(bench, *address) == before


@pytest.mark.spec("A-08")
@pytest.mark.parametrize("local_write", ["ignore", "abort"])
def test_a_value_out_of_range_is_refused_by_its_range_even_then(local_write):
    bench = Bench("topcon", node_id=5, local_write=local_write)
    bench.set(panel="local")
    assert bench.send("605#2B102000A10F0000") == ["585#8010200031000906"]
    assert bench.send("605#2B14200003000000") == ["585#8014200030000906"]


@pytest.mark.spec("T-081", "A-08")
def test_a_stop_is_ignored_too(topcon):
    run(topcon, voltage=2000)
    topcon.run(1.0)
    topcon.set(panel="local")
    topcon.sdo["Run command"].raw = 0
    assert topcon.sdo["Run command"].raw == 1
    assert state_of_output(topcon) == 0x0003


@pytest.mark.spec("A-08")
def test_communication_objects_save_and_the_register_address_work_beside_the_panel(local):
    local.sdo["Producer Heartbeat Time"].raw = 100
    assert local.run(0.1) == ["705#7F"]
    local.sdo["Transmit PDO 1 Communication Parameter"]["Transmission type"].raw = 1
    assert local.send("605#2310100173617665") == ["585#6010100100000000"]
    local.sdo["Register Read/Write"]["Address"].raw = 0x1234
    assert local.sdo["Register Read/Write"]["Address"].raw == 0x1234


@pytest.mark.spec("T-082")
def test_operational_takes_control_from_the_panel_and_does_not_give_it_back(local):
    local.send(START)
    assert in_control(local) == "bus"
    local.set(panel="local")
    assert in_control(local) == "bus"
    local.send("205#E803")
    assert local.sdo["Voltage reference"].raw == 1000


@pytest.mark.spec("T-082")
def test_the_panel_stays_remote_until_somebody_turns_it_again(local):
    local.send(START)
    local.send(ENTER_PREOP)
    local.set(load="resistor 4")
    assert in_control(local) == "bus"
    local.set(panel="local")
    assert in_control(local) == "panel"


@pytest.mark.spec("T-081")
def test_a_reset_of_the_communication_leaves_the_panel_in_control(local):
    local.send(RESET_COMMUNICATION)
    assert in_control(local) == "panel"


@pytest.mark.spec("T-083", "A-08")
def test_settings_and_run_work_in_pre_operational_while_the_panel_is_remote(topcon):
    run(topcon, voltage=2000)
    topcon.run(1.0)
    assert topcon.sdo["Actual voltage"].raw == 2000
    assert state_of_output(topcon) == 0x0003


@pytest.mark.spec("A-09")
@pytest.mark.parametrize(
    ("settings", "word"),
    [({}, 0x0003), ({"on_remote": "keep"}, 0x0003), ({"on_remote": "stop"}, 0)],
)
def test_the_output_when_operational_ends_local_control(settings, word):
    bench = Bench("topcon", node_id=5, **settings)
    run(bench, voltage=2000)
    bench.run(1.0)
    bench.set(panel="local")
    bench.send(START)
    assert state_of_output(bench) == word
    assert bench.sdo["Voltage reference"].raw == 2000


@pytest.mark.spec("A-09")
def test_operational_stops_nothing_when_the_panel_was_remote():
    bench = Bench("topcon", node_id=5, on_remote="stop")
    run(bench, voltage=2000)
    bench.send(START)
    bench.run(1.0)
    assert state_of_output(bench) == 0x0003
