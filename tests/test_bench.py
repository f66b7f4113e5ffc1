import canopen
import pytest
from canopen.nmt import NmtError
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError
from probe import Probe

from canopen_twins import Bench, Twin, UserError


@pytest.fixture
def pair():
    return Bench.of({"left": Probe(5), "right": Probe(6)})


def test_the_twins_of_a_bench_have_power(pair):
    assert pair.sent == ["705#00", "706#00"]


def test_send_returns_what_the_twins_send_before_time_moves(bench):
    assert bench.send("605#4000100000000000") == ["585#4300100000000000"]
    assert bench.send("123#") == []
    assert bench.clock.now == 0.0


def test_run_returns_what_the_twins_send_meanwhile(bench):
    bench.send("605#2B171000E8030000")
    assert bench.run(0.999) == []
    assert bench.run(1.001) == ["705#7F", "705#7F"]
    assert bench.clock.now == 2.0


def test_sent_is_everything_the_twins_have_sent(bench):
    bench.send("605#4000100000000000")
    assert bench.sent == ["705#00", "585#4300100000000000"]


def test_the_trace_has_every_frame_with_time_and_sender(bench):
    bench.run(1.5)
    bench.send("605#4000100000000000")
    assert [str(record) for record in bench.trace] == [
        "(0000000000.000000) can0 705#00",
        "(0000000001.500000) can0 605#4000100000000000",
        "(0000000001.500000) can0 585#4300100000000000",
    ]
    assert [record.sender for record in bench.trace] == ["probe", "", "probe"]


def test_the_same_story_gives_the_same_trace():
    def trace():
        bench = Bench.of({"left": Probe(5), "right": Probe(6)})
        bench.send("605#2B1710000A000000")
        bench.send("000#0100")
        bench.run(0.1)
        bench["right"].inject("level", value=3)
        return [str(record) for record in bench.trace]

    assert trace() == trace()


def test_what_is_no_frame_is_an_error_of_the_user(bench):
    with pytest.raises(UserError, match="is no frame"):
        bench.send("605 40")


def test_an_unknown_device_is_an_error_of_the_user():
    with pytest.raises(UserError, match="unknown device 'nothing'"):
        Bench("nothing")


def test_the_master_is_canopen_s_own(bench):
    assert isinstance(bench.master, canopen.Network)
    assert isinstance(bench.twin.remote, canopen.RemoteNode)


def test_a_real_client_reads_and_writes(bench):
    bench.sdo["Limited"].raw = -7
    assert bench.sdo["Limited"].raw == -7
    bench.sdo["Text"].raw = "longer than one segment"
    assert bench.sdo["Text"].raw == "longer than one segment"
    assert bench.sdo["Device name"].raw == "Probe of the engine"


def test_a_real_client_is_refused(bench):
    with pytest.raises(SdoAbortedError) as refusal:
        bench.sdo["Limited"].raw = 101
    assert refusal.value.code == 0x06090031


def test_a_client_does_not_wait_for_what_never_comes(bench):
    bench.send("000#0205")
    with pytest.raises(SdoCommunicationError, match="No SDO response"):
        bench.sdo.upload(0x1000, 0)
    assert (bench.clock.now, bench.sdo.RESPONSE_TIMEOUT) == (0.0, 0.0)


def test_the_master_hears_heartbeats_emergencies_and_pdos(bench):
    remote = bench.twin.remote
    remote.tpdo.read()
    bench.sdo["Producer heartbeat"].raw = 100
    remote.nmt.state = "OPERATIONAL"
    bench.inject("level", value=0x1234)
    bench.inject("error", code=0x2310)
    bench.run(0.1)
    assert remote.nmt.state == "OPERATIONAL"
    assert remote.tpdo[1]["Level"].raw == 0x1234
    assert [emcy.code for emcy in remote.emcy.active] == [0x2310]


def test_what_the_master_sends_periodically_runs_on_the_clock_of_the_bench(operational):
    operational.master.sync.start(0.1)
    assert operational.run(0.35) == ["285#00000000"] * 3
    operational.master.sync.stop()
    assert operational.run(1.0) == []


def test_remote_frames_are_sent_as_such_and_not_heard_by_canopen(operational):
    heard = []
    operational.master.subscribe(0x123, lambda *_: heard.append(True))
    operational.master.send_message(0x285, b"", remote=True)
    assert operational.sent[-1] == "285#00000000"
    operational["probe"].node.wire.send_message(0x123, b"", remote=True)
    operational.segment.deliver()
    assert heard == []


@pytest.mark.parametrize(("can_id", "text"), [(0x7FF, "7FF#"), (0x800, "00000800#")])
def test_what_fits_no_eleven_bits_is_sent_with_twenty_nine(bench, can_id, text):
    bench.master.send_message(can_id, b"")
    assert str(bench.trace[-1].frame) == text
    bench.master.send_periodic(can_id, b"", 0.1)
    bench.run(0.1)
    assert [str(record.frame) for record in bench.trace[-2:]] == [text, text]


def test_several_twins_are_taken_by_name(pair):
    pair["right"].sdo["Byte"].raw = 3
    assert (pair["left"].sdo["Byte"].raw, pair["right"].sdo["Byte"].raw) == (0, 3)
    with pytest.raises(LookupError, match=r"bench\['left'\]"):
        pair.sdo["Byte"].raw = 3


def test_settings_are_those_of_one_device():
    with pytest.raises(UserError, match=r"which device of several has load\?"):
        Bench({"left": Probe(5)}, load="resistor 4")


def test_faults_are_injected_and_cleared_by_name(bench):
    bench.inject("error", code=0x2310, register=0x03)
    assert bench.sent[-1] == "085#102303" + b"field".hex().upper()
    bench.clear("error")
    assert bench.sent[-1] == "085#0000000000000000"


def test_all_faults_are_cleared_at_once(bench):
    bench.inject("error", code=0x2310)
    bench.clear()
    assert bench.sent[-1] == "085#0000000000000000"


def test_an_unknown_fault_is_an_error_of_the_user(bench):
    with pytest.raises(UserError, match="'error'"):
        bench.inject("eror", code=1)


def test_a_fault_outlives_a_power_cycle(bench):
    bench.inject("error", code=0x2310)
    bench.power_off()
    start = len(bench.sent)
    bench.power_on()
    assert bench.sent[start:] == ["705#00", "085#102301" + b"field".hex().upper()]


def test_another_node_id_can_be_given_at_power_on(bench):
    bench.power_off()
    bench.power_on(node_id=9)
    assert bench.sent[-1] == "709#00"
    assert bench.sdo["Word"].raw == 0x1234


def test_a_node_id_out_of_range_is_an_error_of_the_user(bench):
    bench.power_off()
    for node_id in (0, 128):
        with pytest.raises(UserError, match="node id"):
            bench.power_on(node_id=node_id)


def test_settings_that_are_taken_over_at_power_on_are_refused_while_it_is_on(bench):
    with pytest.raises(UserError, match="power-on only"):
        bench.set(node_id=9)
    with pytest.raises(UserError, match="power is on"):
        bench.power_on(node_id=9)
    assert bench.device.node_id == 5


def test_a_live_setting_acts_at_once(operational):
    operational.set(level=7)
    assert operational.sent[-1] == "185#070000"


def test_looking_at_a_device_brings_it_up_to_the_present(bench):
    bench.run(0.5)
    assert bench.device.steps == [0.5]


def test_a_look_at_a_device_sends_nothing(operational):
    probe = operational.device
    probe.step = lambda dt: probe.on_heartbeat(7, False)
    operational.run(0.5)
    told = list(operational.trace)
    assert operational.device is probe
    assert (operational.report, operational.values("Level")) == ({}, {"Level": 0})
    assert operational.trace == told


def test_what_a_look_at_a_device_brings_to_light_is_sent_before_time_moves(operational):
    probe = operational.device
    probe.step = lambda dt: probe.on_heartbeat(7, False)
    operational.run(0.5)
    assert operational.device is probe
    operational.run(0.5)
    assert str(operational.trace[-1]) == "(0000000000.500000) can0 085#3081110000000000"


def test_what_is_done_by_hand_to_the_device_is_not_sent_by_the_next_look(operational):
    sent = len(operational.sent)
    operational.device.level = 7
    assert operational.device.level == 7
    assert operational.sent[sent:] == []
    assert operational.run(0.0) == ["185#070000"]


def test_a_bench_of_one_twin_is_the_handle_on_it(bench):
    assert isinstance(bench, Twin)
    bench.inject("error", code=0x2310)
    assert bench.sent[-1] == "085#102301" + b"field".hex().upper()
    assert (bench.node_id, bench.state) == (5, "PRE-OPERATIONAL")
    bench.power_off()
    assert (bench.node_id, bench.state, bench.values()) == (5, "INITIALISING", {})


def test_the_values_of_a_twin_are_those_of_its_dictionary_by_the_names_of_the_eds(bench):
    bench.send("605#2F00200007000000")
    assert bench.values("Byte") == {"Byte": 7}
    assert bench.values("Refusing") == {}  # a master cannot read it either
    with pytest.raises(UserError, match="unknown object 'Bite': did you mean 'Byte'"):
        bench.values("Bite")
    topcon = Bench("topcon")
    assert topcon.values()["Nominal voltage"] == 400
    assert topcon.sent == ["701#00"]


def test_a_master_that_replies_to_what_it_hears_comes_after_all_who_only_listen(bench):
    heard = []
    bench.master.subscribe(0x705, lambda *_: bench.master.send_message(0x123, b""))
    bench.segment.listeners.append(lambda frame, sender: heard.append(str(frame)))
    bench.send("000#8105")
    assert heard == ["000#8105", "705#00", "123#"]


def test_what_is_done_to_the_device_by_hand_counts_for_the_next_frame(bench):
    bench.device.online = False
    assert bench.send("605#4000100000000000") == []
    bench.device.online = True
    assert bench.send("605#4000100000000000")[0] == "705#00"


def test_what_is_done_to_the_device_by_hand_counts_for_the_time_that_follows(bench):
    probe = bench.device
    probe.rest = 0.0
    bench.run(0.1)
    assert len(probe.steps) == 10


@pytest.mark.parametrize("reset", ["RESET COMMUNICATION", "RESET"])
def test_the_boot_up_of_a_reset_is_waited_for_though_it_has_come(bench, reset):
    nmt = bench.remote.nmt
    nmt.state = reset
    nmt.wait_for_bootup(5)
    assert (nmt.state, bench.clock.now) == ("PRE-OPERATIONAL", 0.0)


def test_a_boot_up_that_is_still_to_come_takes_the_time_of_the_bench():
    bench = Bench("topcon", node_id=5)
    nmt = bench.remote.nmt
    bench.power_off()
    bench.clock.after(2.0, bench.power_on)
    nmt.wait_for_bootup(60)
    assert "705#00" in bench.sent
    assert 2.0 <= bench.clock.now < 60.0


def test_a_boot_up_that_does_not_come_is_an_error_after_the_time_of_the_bench(bench):
    nmt = bench.remote.nmt
    bench.run(1.0)
    with pytest.raises(NmtError, match="Timeout waiting for boot-up"):
        nmt.wait_for_bootup(5)
    assert bench.clock.now == 6.0


def test_a_boot_up_is_an_answer_to_the_last_command_only(bench):
    nmt = bench.remote.nmt
    nmt.state = "RESET"
    bench.power_off()
    nmt.state = "RESET"
    with pytest.raises(NmtError):
        nmt.wait_for_bootup(1)


def test_a_heartbeat_is_waited_for_in_the_time_of_the_bench(bench):
    bench.sdo["Producer heartbeat"].raw = 1000
    assert bench.remote.nmt.wait_for_heartbeat() == "PRE-OPERATIONAL"
    assert bench.clock.now == 1.0
    bench.sdo["Producer heartbeat"].raw = 0
    with pytest.raises(NmtError):
        bench.remote.nmt.wait_for_heartbeat(2)


def test_a_node_that_is_added_by_hand_waits_in_the_same_way(bench):
    states = []
    node = canopen.RemoteNode(5, bench.device.dictionary())
    node.nmt.add_heartbeat_callback(states.append)
    bench.master.add_node(node)
    node.nmt.state = "RESET"
    node.nmt.wait_for_bootup()
    assert states == [0]


def test_node_guarding_sends_remote_frames(bench):
    bench.remote.nmt.start_node_guarding(0.1)
    bench.run(0.25)
    bench.remote.nmt.stop_node_guarding()
    bench.run(1.0)
    assert [str(record.frame) for record in bench.trace[1:]] == ["705#R", "705#R"]
