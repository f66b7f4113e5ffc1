"""The public door: everything from one import, and nothing imported before it is asked for."""

import pydoc
import subprocess
import sys

import pytest

import canopen_twins


def said(code):
    """What a fresh interpreter prints."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.strip()


@pytest.mark.parametrize("name", canopen_twins.__all__)
def test_every_name_is_there_and_says_what_it_is(name):
    assert name in dir(canopen_twins)
    assert getattr(canopen_twins, name) is getattr(canopen_twins, name)


def test_a_name_that_is_not_there_is_told_as_python_tells_it():
    with pytest.raises(AttributeError, match="module 'canopen_twins' has no attribute 'Bank'"):
        _ = canopen_twins.Bank


def test_opening_it_imports_nothing_of_can():
    code = "import sys, canopen_twins; print({'can', 'canopen', 'yaml'} & set(sys.modules))"
    assert said(code) == "set()"


def test_a_star_brings_all_of_it():
    names = {}
    exec("from canopen_twins import *", names)
    assert set(canopen_twins.__all__) <= set(names)


def test_help_tells_of_it():
    told = pydoc.render_doc(canopen_twins, renderer=pydoc.plaintext)
    assert "Digital twins of CANopen slaves" in told
    assert "class Bench" in told


def test_a_scenario_is_loaded_and_played_through_it(tmp_path):
    story = tmp_path / "boot.twin.yaml"
    story.write_text(
        "version: 1\nnode: {device: topcon, node_id: 5}\n"
        "steps: [{at: 0, expect: {frame: 705#00, within: 1}}]\n"
    )
    assert canopen_twins.play(canopen_twins.load(story)).ok
    assert canopen_twins.play(canopen_twins.load(str(story))).ok
