import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import matplotlib as mpl
import pytest

from canopen_twins.record.plot import look
from canopen_twins.record.plot.run import MOST_MARKS
from canopen_twins.scenario import load
from tests.plot.conftest import HEAD, Svg, draw, find

ROOT = Path(__file__).parents[2]
SHIPPED = ROOT / "scenarios"
STEPS = """\
- {at: 1, write: {0x2100: 50}}
- {at: 2, inject: {error: {code: 0x1234}}}
- {at: 3, clear: error}
- {at: 4, write: {0x2100: 200}}
- {at: 4, nmt: start}
- {at: 4, expect: {value: {0x2100: 200}}}
- {at: 5, expect: {value: {0x2100: 7}}}
- {at: 10, expect: {silence: true, within: 0}}
"""


@pytest.fixture(scope="module")
def svg(tmp_path_factory):
    """The picture of these steps, which end after 10 s."""
    path = tmp_path_factory.mktemp("picture") / "story.yaml"
    path.write_text(HEAD.format("A story") + STEPS)
    return Svg(draw(load(path, find), path.with_suffix(".svg")).read_text("utf-8"))


def place_of(seconds):
    """Where a time is, in points from the left."""
    return 72 * (look.LEFT + look.AXIS * seconds / 10)


def test_the_title_is_the_name_and_the_verdict(svg):
    title, verdict = svg.texts[-2:]
    assert title == "A story"
    assert verdict.endswith("story.yaml: FAIL (2 PASS, 1 FAIL)")


def test_a_curve_ends_with_its_last_value(svg):
    assert "Level" in svg.texts
    assert "[m]" in svg.texts
    assert {"actual → 200 m", "set → 100 m"} <= set(svg.texts)


def test_a_curve_steps_when_its_value_does(svg):
    corners = svg.path("meter.level.actual")
    assert corners[0][0] == pytest.approx(place_of(0))
    assert corners[-1][0] == pytest.approx(place_of(10), abs=0.01)
    rises = [x for (x, y), (_, other) in pairwise(corners) if y != other]
    assert rises == pytest.approx([place_of(1), place_of(4)], abs=0.01)
    nothing, half, full = (corners[at][1] for at in (0, 2, -1))
    assert (nothing - half) / (nothing - full) == pytest.approx(50 / 200, abs=1e-4)


def test_the_set_value_has_a_line_of_its_own(svg):
    actual, wanted = svg.path("meter.level.actual"), svg.path("meter.level.set")
    assert [x for x, _ in actual] == [x for x, _ in wanted]
    assert wanted[-1][1] > actual[-1][1]  # lower: y counts from the top


def test_an_emergency_is_marked_at_its_time_with_its_code(svg):
    marks = {line[0] for line in svg.lines(look.EMCY)}
    assert sorted(marks) == pytest.approx([place_of(2), place_of(3)], abs=0.01)
    assert svg.text_at("1234h") == pytest.approx(place_of(2) + 72 * look.PAD, abs=0.01)
    assert svg.text_at("0000h") == pytest.approx(place_of(3) + 72 * look.PAD, abs=0.01)


def test_a_failed_expectation_is_marked_at_its_time_with_its_line(svg):
    marks = {line[0] for line in svg.lines(look.FAILED) if len(line) == 4 and line[0] == line[2]}
    assert sorted(marks) == pytest.approx([place_of(5)], abs=0.01)
    assert svg.text_at("FAIL line 11") == pytest.approx(place_of(5) + 72 * look.PAD, abs=0.01)


def test_a_fault_is_a_bar_with_its_name(svg):
    assert "error(code=4660)" in svg.texts


def test_a_fault_that_is_over_at_once_is_marked_with_its_name(drawn):
    steps = "- {at: 5, inject: {level: {value: 7}}}\n- {at: 10, nmt: start}\n"
    svg = Svg(drawn(steps).read_text("utf-8"))
    assert "faults" in svg.texts
    assert svg.text_at("level(value=7)") == pytest.approx(place_of(5) + 72 * look.PAD, abs=0.01)


def test_of_a_crowd_of_failures_the_first_are_marked(drawn):
    steps = "- {at: 1, every: 0.01, times: 600, expect: {value: {0x2100: 7}}}\n"
    svg = Svg(drawn(steps).read_text("utf-8"))
    marks = {line[0] for line in svg.lines(look.FAILED) if len(line) == 4 and line[0] == line[2]}
    assert len(marks) == MOST_MARKS
    assert "FAIL line 5" in svg.texts
    assert svg.texts[-1].endswith("FAIL (600 FAIL)")


def test_what_was_left_out_after_an_error_is_neither_a_dot_nor_a_cross(drawn):
    steps = "- {at: 1, write: {0x2102: 1}}\n- {at: 2, nmt: start}\n- {at: 3, nmt: stop}\n"
    svg = Svg(drawn(steps).read_text("utf-8"))
    assert "ERROR line 5" in svg.texts
    assert not any(text.startswith("SKIP") for text in svg.texts)
    assert "SKIP" in svg.texts[-1]


def test_states_are_told_by_bars_and_legend(svg):
    assert svg.texts.count("pre-operational") == 2  # in its bar, and in the legend
    assert svg.texts.count("operational") == 2
    assert svg.texts.count("low") == 2
    assert svg.texts.count("high") == 2


def test_a_device_that_shows_nothing_has_its_nmt_state_and_emergencies(story, tmp_path):
    path = tmp_path / "probe.yaml"
    steps = "[{at: 1, inject: {error: {code: 0x1234}}}, {at: 2, nmt: start}]"
    path.write_text(f"{{version: 1, node: {{device: probe}}, steps: {steps}}}")
    from tests.replay.conftest import find as find_probe  # noqa: PLC0415

    svg = Svg(draw(load(path, find_probe), tmp_path / "probe.svg").read_text("utf-8"))
    assert {"probe, node 5", "NMT", "EMCY", "1234h", "pre-operational"} <= set(svg.texts)
    assert not {"device", "actual → 0"} & set(svg.texts)


def test_a_name_is_not_a_formula_and_may_be_in_any_script(drawn):
    name = '"<b>5 $\\\\frac{1}{2}$ & 電圧 \\a"'
    svg = Svg(drawn(STEPS, name=name).read_text("utf-8"))
    assert svg.texts[-2].rstrip() == "<b>5 $\\frac{1}{2}$ & 電圧"


@pytest.mark.parametrize("suffix", ["png", "svg", "html"])
def test_two_runs_give_the_same_bytes(drawn, suffix):
    first = drawn(STEPS, suffix).read_bytes()
    assert drawn(STEPS, suffix).read_bytes() == first
    assert first


PROGRAM = """\
import sys
from canopen_twins.cli import main
for suffix in "png", "svg", "html":
    main(["play", "gateway_power_up.yaml", "--plot", f"{sys.argv[1]}.{suffix}"])
"""


def test_so_do_two_processes(tmp_path, monkeypatch):
    other = "1" if os.environ.get("PYTHONHASHSEED") != "1" else "2"
    subprocess.run(
        [sys.executable, "-c", PROGRAM, tmp_path / "other"],
        cwd=ROOT,
        env={**os.environ, "PYTHONHASHSEED": other},
        stdout=subprocess.DEVNULL,
        check=True,
    )
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(sys, "argv", ["", str(tmp_path / "this")])
    exec(PROGRAM)
    for suffix in ("png", "svg", "html"):
        pictures = [(tmp_path / f"{name}.{suffix}").read_bytes() for name in ("this", "other")]
        assert pictures[0] == pictures[1]


def test_what_somebody_has_told_matplotlib_changes_nothing(drawn):
    first = drawn(STEPS).read_bytes()
    with mpl.rc_context({"lines.linewidth": 9, "axes.facecolor": "black", "font.size": 30}):
        assert drawn(STEPS).read_bytes() == first
        assert mpl.rcParams["font.size"] == 30


@pytest.mark.parametrize("device", ["topcon", "charger", "gateway"])
def test_a_picture_of_every_device_is_as_wide_as_it_says(device, tmp_path):
    path = next(SHIPPED.glob(f"{device}_*.yaml"))
    png = draw(load(path), tmp_path / "run.png").read_bytes()
    assert png.startswith(b"\x89PNG")
    width = int.from_bytes(png[16:20], "big")
    assert width == look.WIDTH * look.RESOLUTION


def test_a_picture_of_a_moment_is_a_picture(drawn):
    assert "A story" in drawn("- {at: 0, nmt: start}\n").read_text("utf-8")
