import re
from pathlib import Path

import pytest

from simulators import devices
from simulators.cli import main

README = Path(__file__).parent.parent / "README.md"


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README.read_text("utf-8"), re.DOTALL)


def test_the_trace_it_shows_is_what_comes_out(capsys):
    assert main(["play", "topcon_overvoltage.yaml"]) == 0
    said = iter(capsys.readouterr().out.splitlines())
    for line in blocks("text")[0].splitlines():
        shown = re.match(r"\(\d+\.\d+\) can0 \S+|\S+: PASS \(\d+ PASS\)", line)[0]
        assert shown in said, shown  # `in` an iterator goes on from the last one found


def test_the_test_it_shows_passes(pytester):
    pytester.makepyfile(blocks("python")[0])
    pytester.runpytest_inprocess("-p", "no:cacheprovider").assert_outcomes(passed=1)


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
