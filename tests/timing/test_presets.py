from dataclasses import dataclass
from io import StringIO
from typing import ClassVar

import pytest
from probe import Probe

from canopen_twins import Bench, UserError, devices
from canopen_twins.cli import main
from canopen_twins.device.timing import IDEAL, NUMBERS, PRESETS, Timing, timing_of
from canopen_twins.scenario import load, load_bench, play

DEVICES = [*devices.names(), "tests/probe.eds"]


@pytest.mark.parametrize("device", DEVICES)
def test_every_device_has_the_vocabulary_and_is_ideal(device):
    created = devices.create(device)
    assert [name for name in NUMBERS if not hasattr(created.settings, name)] == []
    assert created.timing == IDEAL


@pytest.mark.parametrize("device", [device for device in DEVICES if device != "gateway"])
@pytest.mark.parametrize("preset", PRESETS)
def test_a_preset_sets_all_of_them(device, preset):
    assert devices.create(device, timing=preset).timing == PRESETS[preset]


@pytest.mark.parametrize("order", [1, -1])
def test_what_is_said_wins_over_the_preset(order):
    given = dict([("timing", "worst"), ("boot_time", 0.5)][::order])
    timing = devices.create("charger", **given).timing
    assert (timing.boot_time, timing.store_time) == (0.5, PRESETS["worst"].store_time)
    assert devices.create("charger", timing="worst", noise=0).timing.noise == 0


def test_typical_is_no_time_at_all_nowhere_and_worst_is_worse():
    typical, worst = PRESETS["typical"], PRESETS["worst"]
    assert all(0 < getattr(typical, name) < getattr(worst, name) for name in NUMBERS)


def test_a_device_may_have_figures_of_its_own():
    class Slow(Probe):
        timings: ClassVar = {**PRESETS, "typical": Timing(boot_time=7.0)}

    assert Slow(timing="typical").timing == Timing(boot_time=7.0)


def test_settings_that_know_no_times_are_ideal():
    @dataclass(frozen=True)
    class Settings:
        node_id: int = 1

    assert timing_of(Settings()) == IDEAL


def test_an_unknown_preset_is_told():
    with pytest.raises(UserError, match="'timing' is one of ideal, typical, worst, not 'fast'"):
        devices.create("topcon", timing="fast")


FILE = """\
version: 1
timing: typical
nodes:
  left: {device: charger, node_id: 5}
  right: {device: charger, node_id: 6, timing: worst, settings: {answer_time: 0.01}}
"""


@pytest.mark.parametrize("read", [load_bench, lambda path: load(path).nodes])
def test_a_file_and_a_node_of_it_choose_one(tmp_path, read):
    path = tmp_path / "two.yaml"
    story = "steps: [{at: 0, node: left, nmt: start}]\n"
    path.write_text(FILE + (story if read is not load_bench else ""), "utf-8")
    left, right = (spec.create().timing for spec in read(path).values())
    assert left == PRESETS["typical"]
    assert (right.boot_time, right.answer_time) == (PRESETS["worst"].boot_time, 0.01)


def test_it_stands_beside_the_settings(tmp_path):
    path = tmp_path / "two.yaml"
    path.write_text(
        "version: 1\nnodes: {a: {device: charger, settings: {timing: worst}}}\n", "utf-8"
    )
    with pytest.raises(UserError, match="the timing stands beside the settings, not among them"):
        load_bench(path)


def test_a_story_begins_when_all_have_booted(tmp_path):
    path = tmp_path / "story.yaml"
    path.write_text(FILE + "steps: [{at: 0.1, node: right, nmt: start}]\n", "utf-8")
    trace = StringIO()
    play(load(path), trace)
    lines = [line.split() for line in trace.getvalue().splitlines()[:3]]
    assert [(time, text) for time, _, text in lines] == [
        ("(0000000000.000000)", "706#00"),
        ("(0000000000.000000)", "705#00"),
        ("(0000000000.100000)", "000#0106"),
    ]


def test_a_run_without_a_story_begins_there_too(monkeypatch):
    def look(segment, *_):
        assert [str(frame) for _, frame in segment.outbox] == ["705#00"]
        assert segment.clock.now == 0

    monkeypatch.setattr("canopen_twins.cli.run.serve", look)
    assert main(["run", "charger", "-n", "5", "-i", "virtual", "-c", "boot"]) == 0


@pytest.fixture
def run(monkeypatch):
    """The timing of the nodes that a command line would run."""

    def run(*arguments):
        found = []
        monkeypatch.setattr(
            "canopen_twins.cli.run.serve",
            lambda segment, *_: found.extend(node.device.timing for node in segment.nodes),
        )
        main(["run", *arguments, "-i", "virtual", "-c", "timing"])
        return found

    return run


def test_run_is_typical_unless_told_otherwise(run, tmp_path, monkeypatch):
    assert run("charger") == [PRESETS["typical"]]
    assert run("charger", "--set", "timing=ideal") == [IDEAL]
    monkeypatch.chdir("tests")
    assert run("probe.eds") == [PRESETS["typical"]]
    path = tmp_path / "bench.yaml"
    path.write_text("version: 1\nnodes: {one: {device: charger}}\n", "utf-8")
    assert run(str(path)) == [PRESETS["typical"]]
    path.write_text("version: 1\ntiming: worst\nnodes: {one: {device: charger}}\n", "utf-8")
    assert run(str(path)) == [PRESETS["worst"]]


def test_a_scenario_is_run_as_it_is_played(run):
    assert run("--scenario", "topcon_mains.yaml") == [IDEAL]
    assert run("--scenario", "topcon_mains.yaml", "--set", "timing=worst") == [PRESETS["worst"]]


def test_in_ideal_nothing_stands_between_a_request_and_its_service():
    node = Bench("charger", node_id=5).node
    ((handler,),) = [node._stack.routes[0x605, False]]
    assert handler.__name__ == "on_request"
    assert node._stack.measurement is None
