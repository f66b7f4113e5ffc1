from math import inf

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from probe import Probe

from canopen_twins import Bench
from canopen_twins.device.device import Device
from canopen_twins.slave.emcy import Emcy
from canopen_twins.slave.service import State

READ_LEVEL = "605#4000210000000000"


def level(bench):
    (answer,) = bench.send(READ_LEVEL)
    return int(answer[12:14], 16)


def test_power_on_boots_and_says_so_once(bench):
    assert bench.sent == ["705#00"]
    assert bench.device.told == ["power on", "PRE-OPERATIONAL"]
    assert bench.twin.node.state is State.PRE_OPERATIONAL


def test_power_on_does_nothing_to_what_is_on(bench):
    bench.power_on()
    assert bench.sent == ["705#00"]
    assert bench.device.told.count("power on") == 1


def test_without_power_nothing_is_heard_sent_or_stepped(bench):
    bench.device.rest = 0
    bench.send("605#2B17100064000000")
    bench.power_off()
    start = len(bench.device.told)
    assert (bench.send(READ_LEVEL), bench.send("000#8105"), bench.run(5.0)) == ([], [], [])
    assert bench.device.told[start:] == []
    assert bench.twin.node.state is State.INITIALISING
    assert bench.twin.node.slave is None


def test_power_off_is_told_once(bench):
    bench.power_off()
    bench.power_off()
    assert bench.device.told[2:] == ["INITIALISING", "power off"]


def test_a_power_cycle_starts_everything_volatile_afresh(bench):
    bench.send("000#8205")
    for write in ("605#2B17100064000000", "605#2B01200001000000", "605#2B00210007000000"):
        bench.send(write)
    bench.power_off()
    bench.run(1.0)
    bench.power_on()
    assert level(bench) == 0
    assert bench.send("605#4001200000000000") == ["585#4B01200034120000"]
    assert bench.send("605#4017100000000000") == ["585#4B17100000000000"]
    assert bench.run(1.0) == []


class Capacitor(Probe):
    """What is charged outlives the supply, and drains without it."""

    def make_model(self):
        self.volts, self.passed = 100.0, []

    def power_on(self):
        self.told.append("power on")

    def step(self, dt):
        self.passed.append(("on", round(dt, 6)))

    def step_unpowered(self, dt):
        self.passed.append(("off", round(dt, 6)))
        self.volts -= dt


def test_time_passes_without_supply_in_what_outlives_it():
    bench = Bench.of({"probe": Capacitor()})
    bench.run(2.0)
    bench.power_off()
    bench.run(30.0)
    assert bench.device.volts == 70.0
    bench.run(9.0)
    bench.power_on()
    bench.run(1.0)
    assert bench.device.volts == 61.0
    assert bench.device.passed == [("on", 2.0), ("off", 30.0), ("off", 9.0), ("on", 1.0)]


def test_whoever_listens_hears_of_every_state_a_node_enters(bench):
    heard = []
    bench.twin.node.listeners.append(heard.append)
    for request in ("000#0105", "000#0105", "000#0205", "000#8205"):
        bench.send(request)
    bench.power_off()
    assert heard == [
        State.OPERATIONAL,
        State.STOPPED,
        State.INITIALISING,
        State.PRE_OPERATIONAL,
        State.INITIALISING,
    ]


def test_reset_communication_renews_the_communication_area_only(bench):
    for write in ("605#2B17100064000000", "605#2B01200001000000", "605#2B00210007000000"):
        bench.send(write)
    assert bench.send("000#8205") == ["705#00"]
    assert bench.device.told[2:] == ["INITIALISING", "reset communication", "PRE-OPERATIONAL"]
    assert level(bench) == 7
    assert bench.send("605#4001200000000000") == ["585#4B01200001000000"]
    assert bench.send("605#4017100000000000") == ["585#4B17100000000000"]


def test_reset_node_renews_the_application_too(bench):
    for write in ("605#2B17100064000000", "605#2B01200001000000", "605#2B00210007000000"):
        bench.send(write)
    assert bench.send("000#8105") == ["705#00"]
    assert bench.device.told[2:] == ["INITIALISING", "reset node", "PRE-OPERATIONAL"]
    assert level(bench) == 0
    assert bench.send("605#4001200000000000") == ["585#4B01200034120000"]
    assert bench.send("605#4017100000000000") == ["585#4B17100000000000"]


def test_who_looks_into_the_dictionary_of_a_node_makes_none(bench):
    node = bench.twin.node
    assert node.dictionary is node.slave.object_dictionary
    bench.power_off()
    assert 0x1000 in node.dictionary


@pytest.mark.parametrize("reset", ["000#8105", "000#8205"])
def test_no_timer_outlives_a_reset(operational, reset):
    for write in (
        "605#2B17100064000000",  # heartbeat
        "605#23161001E8030700",  # heartbeat consumer of node 7
        "605#2B00180564000000",  # event timer of TPDO 1
        "605#2105200000000000",  # an SDO transfer that is left open
    ):
        operational.send(write)
    operational.send("707#05")
    operational.send(reset)
    assert operational.run(30.0) == []
    assert operational.clock.next_deadline == inf


def test_a_device_that_goes_offline_falls_silent_and_boots_afresh_when_it_is_back(bench):
    bench.device.rest = 0
    bench.send("000#8205")
    for write in ("605#2B17100064000000", "605#2B01200001000000"):
        bench.send(write)
    bench.run(0.1)
    bench.device.online = False
    assert bench.run(1.0) == []
    assert (bench.send(READ_LEVEL), bench.twin.node.state) == ([], State.INITIALISING)
    bench.device.online = True
    assert bench.run(0.01) == ["705#00"]
    assert bench.send("605#4017100000000000") == ["585#4B17100000000000"]
    assert bench.send("605#4001200000000000") == ["585#4B01200034120000"]


def test_a_device_that_is_offline_at_power_on_boots_later():
    probe = Probe()
    probe.online, probe.rest = False, 0
    bench = Bench.of({"probe": probe})
    assert (bench.sent, bench.run(0.5)) == ([], [])
    probe.online = True
    assert bench.run(0.01) == ["705#00"]


def test_a_device_that_is_offline_after_a_reset_boots_when_it_is_back(bench):
    probe = bench.device
    probe.reset_node = lambda: setattr(probe, "online", False)
    assert bench.send("000#8105") == []
    probe.online, probe.rest = True, 0
    bench.inject("level", value=1)
    assert bench.sent == ["705#00", "705#00"]


def test_the_node_id_is_taken_over_by_a_reset(bench):
    probe = bench.device
    probe.configure(node_id=6)
    assert bench.send("605#4014100000000000") == ["585#4314100085000000"]
    assert bench.send("000#8200") == ["706#00"]
    assert bench.send("605#4014100000000000") == []
    assert bench.send("606#4014100000000000") == ["586#4314100086000000"]


def test_a_device_without_rest_is_stepped_every_cycle():
    probe = Probe()
    probe.rest = 0
    bench = Bench.of({"probe": probe})
    bench.run(0.035)
    assert probe.steps == [0.01, 0.01, 0.01]
    bench.run(0.005)
    assert probe.steps == [0.01, 0.01, 0.01, 0.01]


def test_devices_that_move_take_turns_and_whoever_looks_sees_both_up_to_date():
    one, other = Probe(node_id=1), Probe(node_id=2)
    one.rest = other.rest = 0
    bench = Bench.of({"one": one, "other": other})
    seen = []
    bench.clock.every(0.024, lambda: seen.append((len(one.steps), len(other.steps))))
    bench.run(0.1)
    assert seen == [(2, 2), (4, 4), (7, 7), (9, 9)]
    assert one.steps == other.steps == [0.01] * 10


def test_news_of_a_device_that_moves_is_told_in_its_cycle():
    class Failing(Probe):
        def step(self, dt):
            super().step(dt)
            self.emergencies = (Emcy(0x1000, 1),) if len(self.steps) >= 3 else ()

    probe = Failing()
    probe.rest = 0
    bench = Bench.of({"probe": probe})
    bench.run(0.1)
    assert [(record.time, str(record.frame)) for record in bench.trace][-1:] == [
        (0.03, "085#0010010000000000")
    ]
    assert len(probe.steps) == 10


def test_a_device_at_rest_is_not_stepped_until_a_frame_comes(bench):
    probe = bench.device
    bench.run(1.239)
    assert probe.steps == []
    bench.send(READ_LEVEL)
    assert probe.steps == [1.23]  # whole cycles only: the rest comes with the next
    bench.run(0.001)
    bench.send(READ_LEVEL)
    assert probe.steps == [1.23, 0.01]


def test_time_has_passed_before_a_frame_or_a_command_acts(bench):
    probe = bench.device
    bench.run(0.05)
    bench.inject("level", value=3)
    assert probe.steps == [0.05]
    bench.run(0.02)
    bench.send("605#2B00210005000000")
    assert probe.steps == [0.05, 0.02]


def test_a_device_that_rests_for_a_while_is_stepped_when_that_is_over():
    probe = Probe()
    probe.rest = 0.105
    bench = Bench.of({"probe": probe})
    bench.run(0.35)
    assert probe.steps == [0.1, 0.1, 0.1]


def test_rest_counts_from_the_last_step():
    probe = Probe()
    probe.rest = 0.1
    bench = Bench.of({"probe": probe})
    bench.run(0.05)
    bench.send(READ_LEVEL)
    bench.run(0.09)
    assert probe.steps == [0.05]
    bench.run(0.01)
    assert probe.steps == [0.05, 0.1]


def test_a_resting_device_that_is_acted_upon_is_asked_again_how_long_it_rests(bench):
    probe = bench.device
    bench.run(1.0)
    probe.rest = 0
    bench.send(READ_LEVEL)
    bench.run(0.03)
    assert probe.steps == [1.0, 0.01, 0.01, 0.01]
    probe.rest = inf
    bench.run(1.0)
    assert probe.steps[4:] == [0.01]


def test_a_device_is_told_of_every_frame_it_listens_to_and_no_other(bench):
    for text in (READ_LEVEL, "605#40", "080#", "606#4000210000000000", "000#0205", READ_LEVEL):
        bench.send(text)
    assert bench.device.frames == 3


def test_frames_that_nobody_hears_do_not_wake_a_device(bench):
    bench.run(1.0)
    for text in ("123#00", "606#4000210000000000", "00000605#4000210000000000", "605#R"):
        bench.send(text)
    assert bench.twin.node.device.steps == []


@settings(max_examples=30)
@given(
    st.sampled_from([0.0, 0.01, 0.03, 0.25, inf]),
    st.lists(st.tuples(st.floats(0.0, 0.3), st.booleans()), max_size=12),
)
def test_the_model_lags_behind_by_less_than_a_cycle_after_a_frame(rest, pieces):
    probe = Probe()
    probe.rest = rest
    bench = Bench.of({"probe": probe})
    for seconds, heard in pieces:
        bench.run(seconds)
        if heard:
            bench.send(READ_LEVEL)
            assert 0 <= bench.clock.now - sum(probe.steps) < 0.010_001
    assert all(round(dt * 1_000_000) % 10_000 == 0 for dt in probe.steps)


def test_a_device_that_rests_is_armed_by_its_power(bench):
    bench.device.rest = 0.1
    bench.power_off()
    bench.run(1.0)
    bench.power_on()
    bench.run(0.25)
    assert bench.twin.node.device.steps == [0.1, 0.1]


def test_supply_that_comes_between_two_cycles_starts_the_grid_there():
    probe = Probe()
    probe.rest = 0
    bench = Bench.of({"probe": probe})
    bench.power_off()
    bench.run(0.123)
    bench.power_on()
    bench.run(0.02)
    assert probe.steps == [0.01, 0.01]


@pytest.mark.parametrize("request_", ["605#4003210000000000", "605#2F03210001000000"])
def test_a_bug_in_an_object_reaches_the_caller(bench, request_):
    with pytest.raises(KeyError, match="a bug in an object"):
        bench.send(request_)
    assert bench.sent == ["705#00"]


def test_a_bug_in_an_object_of_a_pdo_reaches_the_caller(operational):
    for write in ("605#2302160108000321", "605#2F02160001000000", "605#2302140105040000"):
        operational.send(write)
    with pytest.raises(KeyError, match="a bug in an object"):
        operational.send("405#01")


def test_a_bug_in_the_model_reaches_whoever_lets_time_pass(bench):
    bench.device.rest = 0
    bench.send(READ_LEVEL)
    bench.run(0.1)
    bench.device.falls_over = True
    with pytest.raises(KeyError, match="a bug in the model"):
        bench.run(0.1)


def test_a_bug_in_the_model_reaches_whoever_sends(bench):
    bench.device.falls_over = True
    bench.run(0.1)
    with pytest.raises(KeyError, match="a bug in the model"):
        bench.send(READ_LEVEL)
    bench.run(0.1)
    with pytest.raises(KeyError, match="a bug in the model"):
        bench.sdo.upload(0x2100, 0)


def test_news_of_an_act_goes_out_with_it(bench):
    with bench.twin.node.acting() as probe:
        probe.emergencies = ()
        probe.on_heartbeat(7, False)
    bench.segment.deliver()
    assert bench.sent == ["705#00", "085#3081110000000000"]


class Counting(Probe):
    """Its third frame is one too many."""

    def on_frame(self):
        super().on_frame()
        if self.frames == 3:
            self.emergencies = (Emcy(0x8110, 0x11),)


def test_what_a_frame_does_to_a_device_is_told_after_a_mere_look_as_well():
    bench = Bench(Counting)
    assert [len(bench.send(READ_LEVEL)) for _ in range(4)] == [1, 1, 2, 1]


class Asked(Probe):
    """Counts how often it is asked whether it rests."""

    asked = 0

    @property
    def rest(self):
        self.asked += 1
        return inf

    on_frame = Device.on_frame


def test_after_a_mere_look_a_device_is_not_asked_for_news():
    device = Asked()
    bench = Bench.of({"probe": device})
    for frame in ("605#2F00180201000000", "000#0105"):
        bench.send(frame)
    before = device.asked
    for frame in (READ_LEVEL, "605#4017100000000000", "080#", "185#R"):
        assert bench.send(frame)
        bench.run(0.1)  # at rest, which brings no news either
    assert device.asked == before
    bench.send("605#2B00210007000000")
    assert device.asked > before


def test_heartbeats_let_a_device_rest():
    bench = Bench.of({"probe": Capacitor()})
    bench.send("605#2B17100064000000")
    assert bench.run(2.0) == 20 * ["705#7F"]
    assert bench.device.passed == [("on", 2.0)]
