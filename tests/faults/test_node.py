import pytest
from canopen import SdoCommunicationError

from canopen_twins import Bench, UserError

from .conftest import READ_VOLTAGE, START

BEAT = "705#05"


def times(bench, frame, since=0.0):
    """When the node has sent a frame, in s since a moment."""
    found = [record.time for record in bench.trace if str(record.frame) == frame]
    return [round(time - since, 6) for time in found if time > since]


def test_heartbeats_stop_and_the_node_goes_on(topcon):
    topcon.inject("heartbeat_stopped")
    assert topcon.run(1.0) == []
    assert len(topcon.send(READ_VOLTAGE)) == 1
    topcon.clear()
    assert topcon.run(0.1) == [BEAT]


def test_one_heartbeat_is_missing(topcon):
    topcon.inject("heartbeat_stopped", nth=3, times=1)
    topcon.run(0.5)
    assert times(topcon, BEAT) == [0.1, 0.2, 0.4, 0.5]


def test_heartbeats_are_late(topcon):
    topcon.inject("heartbeat_late", seconds=0.04)
    topcon.run(0.35)
    assert times(topcon, BEAT) == [0.14, 0.24, 0.34]


def test_heartbeats_jitter_as_the_seed_has_it(topcon):
    topcon.inject("heartbeat_jitter", seconds=0.05, seed=3)
    topcon.run(10.04)
    delays = [time - 0.1 * (n + 1) for n, time in enumerate(times(topcon, BEAT))]
    assert len(delays) in (99, 100)
    assert all(-1e-9 <= delay <= 0.05 for delay in delays)
    assert max(delays) - min(delays) > 0.04


def test_heartbeats_show_another_state(topcon):
    topcon.inject("heartbeat_wrong_state", state=0x7F, times=2)
    assert topcon.run(0.3) == ["705#7F", "705#7F", BEAT]


def test_the_boot_up_is_lost_once(topcon):
    topcon.inject("boot_up_lost", times=1)
    assert topcon.send("000#8105") == []
    assert topcon.send("000#8105") == ["705#00"]


def test_the_boot_up_is_repeated(topcon):
    topcon.inject("boot_up_repeated", repeats=2, seconds=0.5)
    assert topcon.send("000#8105") == ["705#00"]
    topcon.run(5.0)
    assert times(topcon, "705#00") == [0.5, 1.0]


def test_the_node_resets_again_and_again(topcon, active):
    topcon.inject("reset_loop", seconds=0.5, times=3)
    topcon.run(0.9)
    assert (active(), topcon.twin.node.state) == (["reset_loop"], "PRE-OPERATIONAL")
    assert topcon.sdo["Producer Heartbeat Time"].raw == 0
    topcon.run(9.0)
    assert times(topcon, "705#00") == [0.5, 1.0, 1.5]
    assert active() == []


def test_the_supply_goes_and_comes_back(topcon, active):
    topcon.inject("power_cycle", seconds=2.0)
    assert not topcon.twin.node.powered
    assert (active(), topcon.send(READ_VOLTAGE), topcon.run(1.9)) == (["power_cycle"], [], [])
    topcon.run(1.0)
    assert (times(topcon, "705#00"), active()) == ([2.0], [])


def test_a_supply_that_is_cleared_is_back_at_once(topcon):
    topcon.inject("power_cycle", seconds=2.0)
    topcon.clear()
    assert topcon.sent[-1] == "705#00"
    assert topcon.run(5.0) == []


def test_a_node_that_was_off_stays_off(topcon):
    topcon.power_off()
    topcon.inject("power_cycle", seconds=1.0)
    topcon.inject("reset_loop", seconds=1.0)
    topcon.run(3.0)
    topcon.clear()
    assert not topcon.twin.node.powered


def test_the_supply_fails_several_times_in_a_row(topcon, active):
    topcon.inject("brown_out", seconds=0.1, pause=0.3, times=3)
    topcon.run(0.85)
    assert active() == ["brown_out"]
    topcon.run(9.0)
    assert times(topcon, "705#00") == [0.1, 0.5, 0.9]
    assert active() == []


def test_a_cause_in_the_device_outlives_a_power_cycle_from_outside(topcon, active):
    topcon.inject("lasting_error", number=0x23)
    topcon.inject("power_cycle", seconds=1.0)
    topcon.run(2.0)
    assert topcon.sdo["Error Register"].raw == 3
    assert active() == ["lasting_error"]


def test_a_second_device_of_this_node_id_answers_too(topcon):
    topcon.inject("duplicate_node_id")
    assert topcon.sent[-1] == "705#00"
    assert topcon.send(READ_VOLTAGE) == ["585#4B20200000000000"] * 2
    topcon.power_off()
    assert topcon.send(READ_VOLTAGE) == ["585#4B20200000000000"]
    topcon.clear()
    assert (topcon.send(READ_VOLTAGE), topcon.segment.nodes) == ([], [topcon.twin.node])


def test_the_second_device_is_plugged_in_as_it_is_delivered(topcon):
    topcon.sdo["Voltage reference"].raw = 1000
    topcon.inject("duplicate_node_id")
    assert topcon.send("605#4010200000000000") == ["585#4B102000E8030000", "585#4B10200000000000"]


def test_the_identity_is_that_of_another_device_also_after_a_reset(topcon):
    identity = topcon.sdo["Identity Object"]
    before = [entry.raw for entry in identity.values()]
    topcon.inject("wrong_identity", entry=1, value=0x12345678)
    assert identity["Vendor ID"].raw == 0x12345678
    topcon.send("000#8105")
    assert identity["Vendor ID"].raw == 0x12345678
    assert [entry.raw for entry in identity.values()][1:] == before[1:]
    topcon.clear()
    assert [entry.raw for entry in identity.values()] == before


def test_the_firmware_is_another_one(topcon):
    before = topcon.sdo.upload(0x100A, 0)
    topcon.inject("wrong_firmware", version="V9.99-experimental")
    assert topcon.sdo.upload(0x100A, 0) == b"V9.99-experimental"
    topcon.clear()
    assert topcon.sdo.upload(0x100A, 0) == before


def test_a_device_without_the_object_cannot_have_another_one_there(bench):
    with pytest.raises(UserError, match="the device has no object 0x100A:00"):
        bench.inject("wrong_firmware")


def test_a_node_that_is_told_apart_by_its_name_goes_wrong_alone():
    bench = Bench.of({"left": ("topcon", 5), "right": ("topcon", 6)})
    bench["left"].inject("sdo_silence")
    with pytest.raises(SdoCommunicationError):
        _ = bench["left"].sdo["Actual voltage"].raw
    assert bench["right"].sdo["Actual voltage"].raw == 0
    bench["left"].inject("power_cycle", seconds=1.0)
    assert bench.send(START) == []
    assert bench["right"].node.powered
