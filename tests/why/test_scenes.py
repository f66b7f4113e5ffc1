"""Where the reasons are shown: in a verdict, in a test that fails, in real time."""

from pathlib import Path
from textwrap import dedent

import pytest

from simulators.replay import load, play

pytest_plugins = ["pytester"]

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
