"""Where the reasons are shown: in a verdict, in a test that fails, in real time."""

from pathlib import Path
from textwrap import dedent

import pytest

from canopen_twins import devices
from canopen_twins.bus.segment import Segment
from canopen_twins.faults import connect
from canopen_twins.scenario import Player, load, play

STORY = """\
version: 1
node: {device: topcon, node_id: 5}
steps:
  - at: 5
    nmt: stop
  - at: 6
    send: 605#2B14200001000000
  - at: 6
    expect: {frame: 185#*, within: 1}
"""


def test_a_failed_expectation_shows_why(tmp_path):
    file = Path(tmp_path / "story.yaml")
    file.write_text(STORY)
    (outcome,) = play(load(file)).outcomes
    assert outcome.scene.splitlines()[-2:] == [
        "  why: 605#2B14200001000000 not answered: the node was stopped, without SDO"
        " (manual 3.1, Tab. 7)",
        "  why: TPDO1: the node is stopped, without PDO (manual 3.1, Tab. 7)",
    ]


def test_an_expectation_that_is_met_shows_nothing(tmp_path):
    file = Path(tmp_path / "story.yaml")
    file.write_text(STORY.replace("frame: 185#*", "emcy: none"))
    (outcome,) = play(load(file)).outcomes
    assert outcome.scene == ""


@pytest.mark.parametrize(
    ("fixture", "act"),
    [
        ("canopen_bench", 'twin.send("605#2B14200007000000")'),
        ("canopen_device", 'twin.inject("error", number=0x30); twin.set(load="open")'),
    ],
)
def test_a_test_that_fails_shows_why(pytester, fixture, act):
    pytester.makepyfile(
        dedent(f"""
        def test_fails({fixture}):
            twin = {fixture}("topcon", node_id=5)
            {act}
            assert False
        """)
    )
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    result.assert_outcomes(failed=1)
    reason = {
        "canopen_bench": "*why: 605#2B14200007000000 refused: no command 7:*(manual 7.3.9)",
        "canopen_device": "*why: EMCY 3300h detail 30h: *(manual 8, Tab. 70)",
    }
    result.stdout.fnmatch_lines([reason[fixture]])


def test_only_the_node_that_was_waited_for_says_why_nothing_came(tmp_path):
    file = Path(tmp_path / "story.yaml")
    file.write_text(
        dedent("""\
        version: 1
        nodes:
          left: {device: topcon, node_id: 5}
          right: {device: topcon, node_id: 6}
        steps:
          - {at: 1, node: left, expect: {heartbeat: any, within: 1}}
        """)
    )
    (outcome,) = play(load(file)).outcomes
    reasons = [line for line in outcome.scene.splitlines() if line.startswith("  why: ")]
    assert reasons == ["  why: there is no heartbeat: Producer Heartbeat Time (manual 7.2.10) is 0"]


def test_a_story_that_begins_later_knows_the_states_of_its_moments(tmp_path):
    file = Path(tmp_path / "story.yaml")
    file.write_text(STORY)
    segment = Segment()
    node = connect(segment, devices.create("topcon", node_id=5), "topcon")
    node.power_on()
    segment.advance(5.5)
    player = Player(load(file), segment, {"topcon": node})
    player.start()
    segment.advance(12.0)
    (outcome,) = player.verdict.outcomes
    assert "  why: 605#2B14200001000000 not answered: the node was stopped" in outcome.scene


@pytest.mark.parametrize(
    ("expected", "reason"),
    [
        ("value: {Actual voltage: {min: 1000}}", "see Actual voltage (manual 7.3.10)"),
        ("state: operational", "the node is stopped, and no NMT command 01h came for it"),
        ("write: {Run command: 0}", "Run command (manual 7.3.9) is in RPDO4, 505h"),
        ("nmt: start", "000#0106 is for node 6, this is node 5"),
        ("silence: true", "705#04 is a heartbeat: Producer Heartbeat Time (manual 7.2.10) is 500"),
    ],
)
def test_every_kind_of_expectation_has_its_reason(tmp_path, expected, reason):
    file = Path(tmp_path / "story.yaml")
    file.write_text(
        dedent(f"""\
        version: 1
        node: {{device: topcon, node_id: 5}}
        steps:
          - {{at: 1, write: {{Producer Heartbeat Time: 500}}}}
          - {{at: 1, send: 000#0106}}
          - {{at: 2, nmt: stop}}
          - {{at: 3, expect: {{{expected}, within: 1}}}}
        """)
    )
    (outcome,) = play(load(file)).outcomes
    assert f"  why: {reason}" in outcome.scene


def test_a_value_that_is_read_has_the_same_reasons(tmp_path):
    file = Path(tmp_path / "story.yaml")
    file.write_text(
        dedent("""\
        version: 1
        node: {device: topcon, node_id: 5}
        steps:
          - {at: 1, inject: interlock_open}
          - {at: 2, write: {Run command: 1}}
          - {at: 3, send: "080#", every: 0.01, times: 20}
          - {after: 1, read: {Actual voltage: 5}}
        """)
    )
    (outcome,) = play(load(file)).outcomes
    assert "  why: without effect now: an error is active, and RUN waits" in outcome.scene
    assert "  why: active: 9000h interlock loop open" in outcome.scene
