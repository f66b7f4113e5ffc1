import pytest
from probe import Probe, configure

from canopen_twins import Bench
from canopen_twins.bench.limits import OutOfTime, SimulatedTimeError, Standstill
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import FEW, Segment
from canopen_twins.errors import UserError
from canopen_twins.faults import connect

READ_TYPE = Frame.parse("605#4000100000000000")


@pytest.fixture
def pair():
    """Two probes, nodes 5 and 6."""
    return Bench.of({"left": Probe(5), "right": Probe(6)})


OTHERS = [(), range(10, 10 + FEW)]
"""Node ids of nodes beside: none, and so many that nobody is asked whom a frame is not for."""


@pytest.fixture(params=OTHERS, ids=["two", "many"])
def some(request):
    """The same two, alone and among many."""
    others = {f"other {node_id}": Probe(node_id) for node_id in request.param}
    return Bench.of({"left": Probe(5), "right": Probe(6), **others})


def test_two_nodes_of_one_id_are_refused():
    segment = Segment()
    connect(segment, Probe(5), "left")
    with pytest.raises(UserError, match="node id 5"):
        connect(segment, Probe(5), "right")


def test_a_node_is_connected_with_its_power_off():
    segment = Segment()
    node = connect(segment, Probe(5), "probe")
    segment.send(READ_TYPE)
    assert not node.powered


def test_listeners_hear_every_frame_in_its_order_with_its_sender():
    segment, heard = Segment(), []
    connect(segment, Probe(5), "probe").power_on()
    segment.listeners.append(lambda frame, sender: heard.append((sender, str(frame))))
    segment.send(READ_TYPE)
    assert heard == [
        ("probe", "705#00"),
        ("", "605#4000100000000000"),
        ("probe", "585#4300100000000000"),
    ]


def test_every_node_answers_a_broadcast_in_the_order_of_connection(pair):
    assert pair.send("000#0100") == ["185#000000", "186#000000"]


def test_what_is_meant_for_one_node_leaves_the_others_alone(pair):
    assert pair.send("606#2F00200007000000") == ["586#6000200000000000"]
    assert pair.send("605#4000200000000000") == ["585#4F00200000000000"]
    assert pair.send("000#0205") == []
    assert pair.send("606#4000200000000000") == ["586#4F00200007000000"]


def test_what_one_node_sends_the_other_hears(pair):
    configure(
        pair,
        "606#2300140106020080",
        "606#2F00160000000000",
        "606#2300160110000021",
        "606#2F00160001000000",
        "606#2300140185010000",  # RPDO 1 of the right takes what TPDO 1 of the left sends
    )
    pair.send("000#0100")
    pair["left"].inject("level", value=0x1234)
    assert pair["right"].sdo["Level"].raw == 0x1234


def test_who_listens_to_what_had_passed_it_by_hears_it_from_then_on(some):
    def level(frame):
        some.send(frame)
        return some["right"].values("Level")["Level"]

    configure(
        some,
        "606#2300140106020080",
        "606#2F00160000000000",
        "606#2300160110000021",
        "606#2F00160001000000",
        "606#2300140106020000",  # RPDO 1 of the right takes 206h
    )
    some.send("000#0106")
    assert [level(frame) for frame in ("206#0100", "3FF#0200")] == [1, 1]
    configure(some, "606#2300140106020080", "606#23001401FF030000")
    assert [level(frame) for frame in ("206#0300", "3FF#0400")] == [1, 4]


@pytest.mark.parametrize("others", OTHERS)
def test_a_node_that_comes_later_hears_what_nobody_had_heard_before(others):
    segment, heard = Segment(), []
    for node_id in (5, *others):
        connect(segment, Probe(node_id), f"node {node_id}").power_on()
    segment.send(Frame.parse("606#4000100000000000"))
    connect(segment, Probe(6), "right").power_on()
    segment.listeners.append(lambda frame, sender: heard.append(sender))
    segment.send(Frame.parse("606#4000100000000000"))
    assert heard == ["right", "", "right"]


def test_a_filter_of_a_fault_takes_and_leaves_frames_at_once(some):
    assert some.send("606#4000100000000000") == ["586#4300100000000000"]
    some["right"].inject("frame_lost")
    assert some.send("606#4000100000000000") == []
    some["right"].clear()
    assert some.send("606#4000100000000000") == ["586#4300100000000000"]


def test_a_node_does_not_hear_itself(pair):
    configure(
        pair,
        "605#2300140105020080",
        "605#2300140185010000",  # RPDO 1 takes what TPDO 1 of the same node sends
    )
    pair.send("000#0105")
    pair["left"].inject("level", value=0x0102)
    assert pair.sent[-1] == "185#020100"
    assert pair["left"].sdo["Byte"].raw == 0
    pair.send("185#030405")
    assert pair["left"].sdo["Byte"].raw == 3


def test_frames_are_delivered_at_the_moment_they_are_sent(pair):
    configure(pair, "605#2B17100064000000", "606#2B17100096000000")
    start = len(pair.trace)
    pair.run(0.31)
    assert [(record.time, record.sender) for record in pair.trace[start:]] == [
        (0.1, "left"),
        (0.15, "right"),
        (0.2, "left"),
        (0.3, "right"),
        (0.3, "left"),
    ]


def test_a_callback_of_the_master_may_send(pair):
    pair.master.subscribe(0x185, lambda *_: pair.master.send_message(0, [0x80, 0x06]))
    assert pair.send("000#0105") == ["185#000000"]
    assert pair.trace[-1].frame == Frame.parse("000#8006")


def test_a_callback_that_waits_for_an_answer_is_told_that_no_real_bus_has_one_for_it(pair):
    pair.master.subscribe(0x185, lambda *_: pair["right"].sdo["Word"].raw)
    with pytest.raises(SimulatedTimeError, match=r"in a callback, at .*test_segment.py:\d+ in "):
        pair.send("000#0105")
    assert pair["right"].sdo["Word"].raw == 0x1234


def test_a_loop_that_lets_no_time_pass_is_no_hang(pair, monkeypatch):
    monkeypatch.setattr(pair.master, "_standstill", Standstill(1000))

    def spin():
        while pair["right"].sdo["Word"].raw == 0x1234:
            pass

    with pytest.raises(OutOfTime, match=r"lets no time pass, at .*test_segment.py:\d+ in spin"):
        spin()
    pair.run(0.1)
    assert pair["right"].sdo["Word"].raw == 0x1234


def test_a_frame_reaches_every_node_before_a_master_replies_to_it(pair):
    configure(
        pair,
        "606#2301140106030080",
        "606#2F01160000000000",
        "606#2301160110000021",
        "606#2F01160001000000",
        "606#2301140185010000",  # RPDO 2 of the right takes TPDO 1 of the left, at SYNC
    )
    pair.send("000#0106")
    pair.master.subscribe(0x185, lambda can_id, data, timestamp: pair.master.sync.transmit())
    pair["left"].inject("level", value=7)
    pair.send("000#0105")
    assert pair["right"].device.level == 7


def test_the_trace_has_the_frame_that_brought_a_bug_to_light(pair):
    with pytest.raises(KeyError):
        pair.send("606#4003210000000000")
    assert str(pair.trace[-1].frame) == "606#4003210000000000"


def test_a_master_on_the_segment_is_heard_by_its_name_and_by_the_nodes():
    segment, heard = Segment(), []
    connect(segment, Probe(5), "probe").power_on()
    segment.deliver()
    segment.listeners.append(lambda frame, sender: heard.append((str(frame), sender)))
    segment.master("tester").put(Frame.parse("605#4000100000000000"))
    segment.deliver()
    assert heard == [("605#4000100000000000", "tester"), ("585#4300100000000000", "probe")]


def test_what_the_twins_have_sent_is_not_what_a_master_has_sent():
    bench = Bench.of({"probe": Probe(5)})
    bench.segment.master("tester").put(Frame.parse("000#0105"))
    bench.segment.deliver()
    assert bench.sent == ["705#00", "185#000000"]
