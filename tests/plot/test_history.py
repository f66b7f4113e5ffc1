from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.faults import connect
from canopen_twins.record.plot.run import MOST_MARKS, Run
from canopen_twins.scenario import play

from .conftest import Meter


def words(track):
    return [(time, band.label) for time, band in track.points]


def test_set_and_actual_value_are_seen_when_they_change(observed):
    (node,) = observed("- {at: 0.5, write: {0x2100: 7}}\n- {at: 1, write: {0x2100: 9}}\n").nodes
    (curve,) = node.curves
    assert curve.actual.points == [(0, 0), (0.5, 7), (1, 9)]
    assert curve.wanted.points == [(0, 0), (0.5, 3.5), (1, 4.5)]


def test_a_value_is_that_at_the_end_of_a_moment(observed):
    (node,) = observed("- {at: 1, write: {0x2100: 7}}\n- {at: 1, write: {0x2100: 9}}\n").nodes
    assert node.curves[0].actual.points == [(0, 0), (1, 9)]


def test_the_states_of_nmt_and_of_the_device_are_seen(observed):
    (node,) = observed(
        "- {at: 1, nmt: start}\n- {at: 2, write: {0x2100: 200}}\n- {at: 3, nmt: stop}\n"
    ).nodes
    assert words(node.nmt) == [(0, "pre-operational"), (1, "operational"), (3, "stopped")]
    assert words(node.state) == [(0, "low"), (2, "high")]


def test_without_power_there_is_nothing(observed):
    (node,) = observed("- {at: 1, power: off}\n- {at: 2, power: on}\n- {at: 3, nmt: start}\n").nodes
    assert node.curves[0].actual.points == [(0, 0), (1, None), (2, 0)]
    states = [(0, "pre-operational"), (1, "power off"), (2, "pre-operational"), (3, "operational")]
    assert words(node.nmt) == states
    assert words(node.state) == [(0, "low"), (1, "power off"), (2, "low")]


def test_what_a_frame_from_outside_does_to_a_device_at_rest_is_seen():
    segment = Segment()
    node = connect(segment, Meter(node_id=5), "meter")
    observer = Run(segment, None)
    node.power_on()
    segment.deliver()
    for time, frame in [(10, "000#0105"), (20, "605#2B00210007000000"), (30, "000#0205")]:
        segment.advance_to(time)
        segment.send(Frame.parse(frame))
    segment.advance_to(40)
    (node,) = observer.nodes
    assert words(node.nmt) == [(0, "pre-operational"), (10, "operational"), (30, "stopped")]
    assert node.curves[0].actual.points == [(0, 0), (20, 7)]


def test_a_fault_is_there_from_inject_to_clear(observed):
    (node,) = observed(
        "- {at: 1, inject: {error: {code: 0x1000}}}\n"
        "- {at: 2, inject: heartbeat_stopped}\n"
        "- {at: 3, clear: error}\n"
    ).nodes
    assert node.faults["error(code=4096)"].points == [(1, True), (3, False)]
    assert node.faults["heartbeat_stopped"].points == [(2, True)]


def test_a_fault_that_is_replaced_by_another_of_its_name_is_over(observed):
    (node,) = observed(
        "- {at: 1, inject: {error: {code: 0x1000}}}\n- {at: 2, inject: {error: {code: 0x2000}}}\n"
    ).nodes
    assert node.faults["error(code=4096)"].points == [(1, True), (2, False)]
    assert node.faults["error(code=8192)"].points == [(2, True)]


def test_a_fault_that_heals_by_itself_is_over_then(observed):
    (node,) = observed("- {at: 1, inject: {error: {code: 0x1000}}, for: 0.5}\n").nodes
    assert node.faults["error(code=4096)"].points == [(1, True), (1.5, False)]


def test_a_fault_that_is_over_at_once_is_a_moment(observed):
    (node,) = observed("- {at: 1, inject: {level: {value: 7}}}\n").nodes
    assert node.blows == [("level(value=7)", 1)]
    assert node.faults == {}


def test_an_emergency_is_taken_down_in_words(observed):
    (node,) = observed(
        "- {at: 1.5, inject: {error: {code: 0x1234}}}\n- {at: 2, clear: all}\n"
    ).nodes
    assert node.emergencies == [
        (1.5, 0x1234, "EMCY 1234h register 01h"),
        (2.0, 0x0000, "EMCY 0000h register 00h no error left"),
    ]


def test_a_storm_of_emergencies_is_counted(observed):
    steps = "".join(
        f"- {{at: {n / 100}, inject: {{error: {{code: {n + 1}}}}}}}\n"
        for n in range(MOST_MARKS + 20)
    )
    (node,) = observed(steps).nodes
    assert len(node.emergencies) == MOST_MARKS
    assert node.untold == 20


def test_a_device_at_rest_is_not_looked_at(story):
    looks = []

    class Counting(Run):
        def _look(self):
            looks.append(self.duration)
            super()._look()

    steps = "- {at: 1, write: {0x2100: 7}}\n- {at: 3600, write: {0x2100: 9}}\n"
    play(story(steps), observers=[Counting])
    assert len(looks) < 10
