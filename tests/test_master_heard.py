"""A scenario that is about a master, in real time, when there is none."""

import pytest

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.faults import connect
from canopen_twins.live.master_watch import MasterWatch
from canopen_twins.scenario import Player, begin, load

ABOUT = """\
  - {at: 0, expect: {write: {Run command: 1}, within: 5}}
  - {when: {nmt: start}, inject: interlock_open}
"""
DRIVEN = "  - {at: 0, write: {Run command: 0}}\n  - {at: 0, expect: {nmt: start, within: 1}}\n"
ALONE = "  - {at: 0, expect: {emcy: any, within: 5}}\n"


@pytest.fixture
def running(tmp_path):
    """A scenario at the moment its twin is on the bus: the bus, and the player."""

    def running(steps):
        file = tmp_path / "story.yaml"
        file.write_text(f"version: 1\nnode: {{device: topcon, node_id: 5}}\nsteps:\n{steps}")
        scenario, segment = load(file), Segment()
        nodes = {name: connect(segment, n.create(), name) for name, n in scenario.nodes.items()}
        player = Player(scenario, segment, nodes)
        begin(segment, player)
        watch = MasterWatch(segment, player)
        watch.start()
        return segment, player

    return running


def test_two_seconds_of_silence_are_told_and_stand_in_the_verdict(running, caplog):
    segment, player = running(ABOUT)
    segment.advance(1.9)
    assert caplog.messages == []
    segment.advance(5)
    assert caplog.messages == ["no master heard for 2 s; still waiting for one"]
    assert [outcome.seen for outcome in player.verdict.outcomes] == [
        "no master heard (none came)",
        "no master heard (1 step from here on was not reached)",
    ]


def test_a_master_that_comes_later_is_judged_by_what_it_does(running, caplog):
    segment, player = running(ABOUT)
    segment.advance(4)
    segment.send(Frame.parse("605#4000100000000000"))
    segment.advance(4)
    assert len(caplog.messages) == 1
    assert player.verdict.outcomes[0].seen == "none came"


@pytest.mark.parametrize("steps", [ALONE, DRIVEN])
def test_where_no_master_is_waited_for_none_is_missed(running, caplog, steps):
    segment, player = running(steps)
    segment.advance(6)
    assert caplog.messages == []
    assert "no master" not in str(player.verdict)
