"""What a player tells of itself while it plays."""

from probe import Probe

from canopen_twins.bus.segment import Segment
from canopen_twins.faults import connect
from canopen_twins.scenario import Player, PlayerEvent

STORY = """\
- {at: 1, nmt: start}
- when: {state: operational}
  inject: {level: {value: 3}, heartbeat_stopped: {}}
- {at: 2, inject: heartbeat_late, for: 0.5}
- {at: 3, clear: all}
- {at: 4, send: 111#, every: 0.5, times: 2}
- {at: 5, expect: {value: {Level: 4}}}
- {at: 6, nmt: reset-communication}
"""


def events_of(scenario):
    segment, told = Segment(), []
    node = connect(segment, Probe(node_id=5), "left")
    player = Player(scenario, segment, {"probe": node})
    player.listeners.append(told.append)
    segment.advance(0.5)
    player.start()
    node.power_on()
    segment.deliver()
    segment.advance(10)
    assert player.done
    return told


def test_everything_that_is_not_in_the_frames_is_told_at_its_time(story):
    told = events_of(story(STORY))
    assert all(event.node == "probe" for event in told if event.kind != "step")
    assert [(event.time, event.kind, *event.fields.values()) for event in told] == [
        (0.0, "state", "PRE-OPERATIONAL"),
        (1.0, "step", 4, "nmt"),
        (1.0, "state", "OPERATIONAL"),
        (1.0, "step", 5, "inject"),
        (1.0, "inject", "level", {"value": 3}),
        (1.0, "inject", "heartbeat_stopped", {}),
        (2.0, "step", 7, "inject"),
        (2.0, "inject", "heartbeat_late", {}),
        (2.5, "clear", "heartbeat_late"),
        (3.0, "step", 8, "clear"),
        (3.0, "clear", "heartbeat_stopped"),
        (4.0, "step", 9, "send"),
        (4.5, "step", 9, "send"),
        (5.0, "step", 10, "Level 4 at once"),
        (5.000001, "outcome", "FAIL", 10, "Level 4 at once", "Level is 3"),
        (6.0, "step", 11, "nmt"),
        (6.0, "state", "INITIALISING"),
        (6.0, "state", "PRE-OPERATIONAL"),
    ]


def test_a_step_that_is_about_no_node_says_so(story):
    (event,) = [each for each in events_of(story("- {at: 1, send: 111#}\n")) if each.kind == "step"]
    assert event == PlayerEvent(1.0, "", "step", {"line": 4, "what": "send"})


def test_the_same_scenario_tells_the_same_each_time(story):
    assert events_of(story(STORY)) == events_of(story(STORY))
