from simulators import Bench
from simulators.device import Device
from simulators.segment import Segment
from simulators.wire import Frame


class Quiet(Device):
    eds = "topcon.eds"
    title = "the dictionary of a TopCon with nothing behind it"


def test_a_master_on_the_segment_is_heard_by_its_name_and_by_the_nodes():
    segment, heard = Segment(), []
    segment.node(Quiet(node_id=5), "quiet").power_on()
    segment.deliver()
    segment.listeners.append(lambda frame, sender: heard.append((str(frame), sender)))
    segment.master("tester").put(Frame.parse("605#4000100000000000"))
    segment.deliver()
    assert heard == [("605#4000100000000000", "tester"), ("585#4300100000000000", "quiet")]


def test_what_the_twins_have_sent_is_not_what_a_master_has_sent():
    bench = Bench.of({"quiet": Quiet(node_id=5)})
    bench.segment.master("tester").put(Frame.parse("000#0105"))
    bench.segment.deliver()
    assert bench.sent == ["705#00"]
