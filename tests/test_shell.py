"""What a shell, its manual and programs are told of the commands."""

import json
import shlex
import shutil
import subprocess
import sys

import pytest

from canopen_twins import devices
from canopen_twins.cli import COMMANDS, main, parser
from canopen_twins.cli.examples import EXAMPLES

NAMES = [name for told in COMMANDS.values() for name in told]
COMPLETE = """
source /dev/stdin <<< "$1"
COMP_WORDS=({words}) COMP_CWORD={last} COMP_LINE="{words}" COMP_POINT={point}
_shtab_canopen_twin canopen-twin {word} {before}
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


@pytest.fixture
def printed(capsys):
    def printed(*arguments):
        assert main(arguments) == 0
        return capsys.readouterr().out

    return printed


def test_every_command_has_examples_and_they_can_be_typed():
    assert EXAMPLES.keys() == set(NAMES)
    for example in (each for examples in EXAMPLES.values() for each in examples):
        words = shlex.split(example.partition(" >")[0])
        assert parser().parse_args(words).command is not None


@pytest.mark.parametrize("command", NAMES)
def test_help_ends_with_examples(command, capsys):
    with pytest.raises(SystemExit):
        main([command, "--help"])
    *_, told = capsys.readouterr().out.partition("examples:\n")
    assert told.splitlines() == [f"  canopen-twin {example}" for example in EXAMPLES[command]]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_understands_its_script_that_knows_commands_options_and_devices(printed, shell):
    script = printed("completion", shell)
    assert all(word in script for word in [*NAMES, "nvram", *devices.names()])
    if shutil.which(shell):
        subprocess.run([shell, "-n"], input=script, text=True, check=True, timeout=60)


@pytest.mark.parametrize(
    ("typed", "wanted"),
    [("canopen-twin comp", "compare"), ("canopen-twin run top", "topcon")],
)
def test_bash_completes(printed, typed, wanted):
    words = typed.split()
    text = COMPLETE.format(
        words=typed, last=len(words) - 1, point=len(typed), word=words[-1], before=words[-2]
    )
    script = printed("completion", "bash")
    command = ["bash", "-c", text, "bash", script]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    assert wanted in done.stdout.split()


def test_the_page_of_the_manual_has_every_command_with_its_options(printed):
    page = printed("man").replace("\\-", "-")
    assert ".TH CANOPEN-TWIN" in page
    assert all(f"canopen-twin {name}" in page for name in NAMES)
    assert "--nvram" in page


def test_programs_are_told_of_devices_and_their_scenarios(printed):
    told = json.loads(printed("list", "--json"))
    assert [*told] == devices.names()
    assert told["topcon"]["title"].startswith("Regatron TopCon")
    assert told["topcon"]["scenarios"]["topcon_overvoltage.yaml"] == "TopCon trips on overvoltage"
    assert [*json.loads(printed("list", "charger", "--json"))] == ["charger"]


def test_programs_are_told_of_objects(printed):
    told = {each["object"]: each for each in json.loads(printed("objects", "topcon", "--json"))}
    assert told["0x2010:00"] == {
        "object": "0x2010:00",
        "name": "Voltage reference",
        "type": "INTEGER16",
        "access": "rw",
        "pdo": True,
        "default": None,
        "low": 0,
        "high": 4000,
    }


def test_programs_are_told_of_settings(printed):
    told = json.loads(printed("settings", "topcon", "--json"))
    assert (told["load"]["default"], told["load"]["live"]) == ("open", True)
    assert told["timing"]["choices"] == ["ideal", "typical", "worst"]
    assert told["boot_time"] | {"text": ""} == {
        "default": None,
        "text": "",
        "type": "number",
        "choices": [],
        "optional": True,
        "unit": "s",
        "low": 0,
        "high": None,
        "assumed": "",
        "live": False,
    }


@pytest.mark.parametrize("name", ["shtab", "argparse_manpage.manpage"])
def test_without_the_extra_one_line_says_so(monkeypatch, capsys, name):
    monkeypatch.setitem(sys.modules, name, None)
    command = ["completion", "bash"] if name == "shtab" else ["man"]
    assert main(command) == 2
    assert "pip install 'canopen-twins[shell]'" in capsys.readouterr().err
