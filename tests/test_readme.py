import re
import shlex
from pathlib import Path

import pytest

from canopen_twins import devices
from canopen_twins.cli import main
from canopen_twins.files.shipped import scenarios

README = Path(__file__).parent.parent / "README.md"


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README.read_text("utf-8"), re.DOTALL)


def test_the_trace_it_shows_is_what_comes_out(capsys):
    assert main(["play", "topcon_overvoltage.yaml"]) == 0
    said = iter(capsys.readouterr().out.splitlines())
    for line in blocks("text")[0].splitlines():
        assert line in said, line  # `in` an iterator goes on from the last one found


def test_the_test_it_shows_passes(pytester):
    pytester.makepyfile(blocks("python")[0])
    pytester.runpytest_inprocess("-p", "no:cacheprovider").assert_outcomes(passed=1)


def test_a_master_that_ignores_the_emcy_is_told_what_it_shows(pytester):
    pytester.makefile(".yaml", trip=blocks("yaml")[0])
    pytester.makepyfile("""
        def test_it(canopen_scenario):
            bench = canopen_scenario("trip.yaml")
            for _ in range(2):
                bench.sdo["Run command"].raw = 1
                bench.run(0.1)
    """)
    run = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    run.assert_outcomes(failed=1)
    said = iter(run.outlines)
    for line in blocks("text")[1].splitlines():
        assert any(line.strip(" .") in shown for shown in said), line


def test_the_commands_it_shows_do_what_it_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for line in blocks("console")[0].splitlines():
        assert main(shlex.split(line.removeprefix("$ canopen-twin "))) == 0
    told = re.search(r"\*(refused [^*]+)\*", README.read_text("utf-8"))[1]
    assert f"7 in operational: {told}\n" in capsys.readouterr().out


def test_it_counts_the_scenarios():
    assert f"There are {len(scenarios())} such stories" in README.read_text("utf-8")


@pytest.mark.parametrize("device", devices.names())
def test_it_names_every_device(device):
    assert f"| `{device}` |" in README.read_text("utf-8")


def test_its_first_two_commands_make_their_own_environment():
    play, bus, tests = blocks("sh")
    for command in (play, tests):
        assert command.startswith("python3 -m venv .venv && .venv/bin/pip install ")
    assert "canopen-twin play" in play
    assert "canopen-twin run" in bus
    assert "-m pytest" in tests
