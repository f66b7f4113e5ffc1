import pytest
from probe import Probe

from canopen_twins import Bench, UserError, devices
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.faults import connect
from canopen_twins.scenario import Kind, Player

STORY = """\
- {at: 0, expect: {frame: 705#00, within: 0}}
- {at: 0.5, write: {Producer heartbeat: 70}}
- {at: 1, nmt: start}
- {at: 1, expect: {heartbeat: operational, within: 0.1}}
- {at: 1.5, inject: {error: {code: 0x1000}}}
- {at: 1.5, expect: {emcy: {code: 0x1000}, within: 0}}
- {at: 2, expect: {value: {Error history.Number of errors: 1}, within: 1}}
- {at: 2, expect: {emcy: none, within: 1.5}}
"""
MOMENTS = """\
- {when: {state: operational}, inject: {sdo_late: {seconds: 0.05}}, for: 0.7}
- {after: 0.1, write: {Byte: 3, Text: a long text}}
- {after: 0, read: {Text: a long text}}
- {when: {value: {Byte: 4}}, send: 111#, every: 0.0303, times: 5}
- {when: {frame: 111#, from: master, nth: 4}, inject: {error: {code: 0x1000}}}
- when: {emcy: any}
  expect: {write: {Byte: 0}, before: {nmt: stop}}
- {at: 0.5, nmt: start}
- {at: 2, write: {Byte: 4}}
- {at: 2.5, send: 205#000000}
- {at: 2.6, expect: {never: {write: {Byte: any}}}}
- {at: 2.7, nmt: stop}
cleanup:
  - {power: off}
  - {after: 0.01, expect: {silence: true, within: 0.1}}
"""
READ = Frame.parse("605#4008200000000000")


class Stage:
    """A segment with a node 5, a player that has started, and what they have sent since then."""

    def __init__(self, scenario, pause=0.0, device=None):
        self.segment = Segment()
        self.node = connect(self.segment, device or Probe(node_id=5), "left")
        self.sent = []
        self.segment.listeners.append(self._hear)
        self.segment.advance(pause)
        self._begin = self.segment.clock.ticks
        self.player = Player(scenario, self.segment, {"probe": self.node})
        self.player.start()
        self.node.power_on()
        self.segment.deliver()

    def _hear(self, frame, sender):
        self.sent.append((self.segment.clock.ticks - self._begin, str(frame), sender))

    @property
    def outcomes(self):
        return [(each.kind, each.line, each.seen) for each in self.player.verdict.outcomes]


@pytest.fixture
def stage(story):
    return lambda steps=STORY, **how: Stage(story(steps), **how)


@pytest.mark.parametrize("steps", [STORY, MOMENTS])
def test_it_does_not_matter_who_drives_the_clock_nor_when_it_began(stage, steps):
    at_once, late, jerky = stage(steps), stage(steps, pause=12.345678), stage(steps)
    at_once.segment.advance(5)
    late.segment.advance(5)
    for part in [0.0137] * 365:
        jerky.segment.advance(part)
    assert at_once.player.verdict.ok
    assert at_once.player.verdict == late.player.verdict == jerky.player.verdict
    assert at_once.sent == late.sent == jerky.sent


def test_frames_of_the_scenario_carry_its_name_and_so_find_a_real_bus(stage):
    stage = stage("- {at: 1, send: 080#}\n- {at: 2, nmt: stop}\n- {at: 3, write: {Byte: 1}}\n")
    stage.segment.advance(3)
    assert stage.sent == [
        (0, "705#00", "left"),
        (1_000_000, "080#", "scenario"),
        (2_000_000, "000#0205", "scenario"),
        (3_000_000, "605#2F00200001000000", "scenario"),
    ]


def test_it_is_done_when_the_last_expectation_is_decided(stage):
    stage = stage()
    stage.segment.advance(3.5)
    assert not stage.player.done
    stage.segment.advance(0.000001)
    assert stage.player.done


def test_what_has_come_early_is_not_waited_for(stage):
    stage = stage("- {at: 1, expect: {frame: 585#xxxxxxxxxxxxxxxx, within: 60}}\n")
    stage.segment.advance(2)
    assert not stage.player.done
    stage.segment.send(READ)
    assert stage.player.done
    assert stage.player.verdict.outcomes[0].time == 2


def test_what_is_not_decided_yet_is_an_error(stage):
    stage = stage()
    assert not stage.player.verdict.ok
    stage.segment.advance(1.2)
    assert stage.outcomes == [
        (Kind.PASS, 4, "705#00"),
        (Kind.PASS, 7, "operational"),
        (Kind.ERROR, 8, "4 steps from here on were not reached"),
    ]
    stage.segment.advance(1)
    assert stage.outcomes[-1] == (Kind.ERROR, 11, "the run ended before it was decided")


def test_another_node_does_not_speak_for_the_one_that_is_meant(stage):
    stage = stage("- {at: 1, expect: {silence: true, within: 1}}\n")
    other = connect(stage.segment, Probe(node_id=6), "right")
    stage.segment.advance(1.5)
    other.power_on()
    stage.segment.deliver()
    stage.segment.advance(1.5)
    assert stage.sent[-1] == (1_500_000, "706#00", "right")
    assert stage.outcomes == [(Kind.PASS, 4, "none came")]


def test_a_node_that_is_another_than_the_file_says_makes_an_error_of_what_it_refuses(stage):
    device = devices.create("topcon", node_id=5)
    stage = stage("- {at: 1, inject: {level: {value: 1}}}\n", device=device)
    stage.segment.advance(1)
    ((kind, line, seen),) = stage.outcomes
    assert (kind, line) == (Kind.ERROR, 4)
    assert seen.startswith("unknown fault 'level'")


def test_a_scenario_about_a_node_that_is_not_there_is_refused(story):
    bench = Bench("topcon", node_id=5)
    with pytest.raises(UserError, match=r"story\.yaml is about a probe; here is topcon"):
        Player(story(STORY), bench.segment, {"topcon": bench.twin.node})


def test_a_bench_plays_it_too_and_its_twins_have_sent_what_they_have_sent(story):
    bench = Bench.of({"probe": Probe(node_id=5)})
    player = Player(
        story("- {at: 1, write: {Byte: 1}}\n"), bench.segment, {"probe": bench["probe"].node}
    )
    player.start()
    assert bench.run(1) == ["585#6000200000000000"]
    assert player.verdict.ok
