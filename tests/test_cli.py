import json
import re
import signal
import subprocess
import sys

import pytest
from until_ready import run_until_ready

from canopen_twins import Bench, devices
from canopen_twins.cli import main
from canopen_twins.cli.scenario_file import load
from canopen_twins.files.shipped import od_file, scenarios
from canopen_twins.files.whole import held

RUN = [
    sys.executable,
    "-m",
    "canopen_twins",
    "run",
    "topcon",
    "-n",
    "5",
    "-i",
    "virtual",
    "-c",
    "cli",
]


@pytest.fixture
def said(capsys):
    """Run a command in this process: its exit code and what it said on stdout and stderr."""

    def run(*arguments):
        try:
            code = main(arguments)
        except SystemExit as end:  # argparse's own way out
            code = end.code
        return code, *capsys.readouterr()

    return run


def test_every_device_and_every_scenario_is_listed(said):
    code, out, _ = said("list")
    assert code == 0
    for name in [*devices.names(), *scenarios()]:
        assert name in out


def test_a_scenario_is_listed_with_its_name_among_those_of_its_device(said):
    _, out, _ = said("list")
    groups = [group.splitlines() for group in out.split("\n\n")[1:]]
    assert [{line.partition("_")[0] for line in group} for group in groups] == [
        {device} for device in devices.names()
    ]
    told = dict(re.split(r"  +", line) for group in groups for line in group)
    assert list(told) == list(scenarios())
    assert told["topcon_overvoltage.yaml"] == load("topcon_overvoltage.yaml").name


def test_the_scenarios_of_one_device_are_listed_alone(said):
    code, out, _ = said("list", "charger")
    files = [line.split()[0] for line in out.splitlines()]
    assert (code, files) == (0, [name for name in scenarios() if name.startswith("charger_")])


@pytest.mark.parametrize("device", devices.names())
def test_every_entry_of_every_device_is_told(said, device):
    code, out, _ = said("objects", device)
    entries = devices.create(device).dictionary()
    subs = [getattr(item, "subindices", [0]) for item in entries.values() if item.index >= 0x1000]
    assert (code, out.count("\n") - 1) == (0, sum(map(len, subs)))


def test_an_entry_is_told_with_type_access_default_and_limits(said):
    _, out, _ = said("objects", "topcon")
    lines = {line.split()[0]: line.split() for line in out.splitlines()}
    assert lines["0x2010:00"][1:] == ["Voltage", "reference", "INTEGER16", "rw", "0..4000"]
    assert lines["0x1400:02"][-2:] == ["rw", "0xFE"]


@pytest.mark.parametrize("device", devices.names())
def test_every_setting_and_every_fault_of_every_device_is_told(said, device):
    _, told, _ = said("settings", device)
    names = [line.split()[0] for line in told.splitlines()[1:]]
    assert names == list(devices.find(device).settings.__dataclass_fields__)
    _, told, _ = said("faults", device)
    for name, fault in Bench(device).twin.node.faults.known.items():
        assert f"{name}\n    {fault.text}\n" in told


def test_the_faults_of_every_device_are_told_level_by_level(said):
    _, told, _ = said("faults")
    headings = ["protocol level:", "node level:", "line level:", "Which one is struck"]
    places = [told.index(heading) for heading in headings]
    assert places == sorted(places)
    assert "    The master sees: A time-out; what was written is written.\n" in told
    assert "    code: abort code (default: 0x08000000)\n" in told
    assert "    cob_id: the identifier it has (default: 0x57F)\n" in told
    assert "    nth, times, probability, burst, seed: which one is struck\n" in told
    assert told.count("the first one that is struck, counted from 1 (default: 1)") == 1


def test_numbers_that_a_manual_prints_in_decimal_are_told_in_decimal(said):
    _, told, _ = said("faults", "gateway")
    assert "    number: 3001..3094 (default: 3094)\n" in told
    assert "    rpm: how fast; above 2070 rpm it is stopped (default: 2100)\n" in told
    assert "    identifier: of TPDO5 (default: 0x100)\n" in told


def test_a_text_that_is_empty_is_not_told_as_a_default(said):
    _, told, _ = said("faults", "charger")
    assert "    key: its key in the catalogue\n" in told


def test_faults_are_told_to_programs(said):
    _, told, _ = said("faults", "topcon", "--json")
    faults = json.loads(told)
    assert faults["interlock_open"]["level"] == "device"
    assert faults["heartbeat_late"]["parameters"]["seconds"] == {
        "text": "by how much, in s",
        "type": "number",
        "default": 1.0,
        "low": 0,
        "high": None,
    }


def test_the_eds_is_printed_as_it_is_shipped(said):
    with od_file("topcon.eds") as path:
        assert said("eds", "topcon") == (0, path.read_text("ascii"), "")


WRONG = [
    (["objects", "topkon"], "unknown device 'topkon': did you mean 'topcon'?"),
    (["run", "topcon", "-n", "0"], "node id 0 is not in 1..127"),
    (["run", "topcon", "-n", "128"], "node id 128 is not in 1..127"),
    (["run", "topcon", "--set", "laod=open"], "unknown setting 'laod': did you mean 'load'?"),
    (["run", "topcon", "--set", "load"], "--set load: write it as KEY=VALUE"),
    (["run", "topcon", "--set", "serial=x"], "setting 'serial' wants a whole number, not 'x'"),
    (["list", "topkon"], "unknown device 'topkon': did you mean 'topcon'?"),
    (["play", "nothing.yaml"], "unknown file or shipped scenario 'nothing.yaml'"),
    (["run", "-i", "virtual"], "nothing to run: say which device, or --scenario with a file"),
    (["run", "--hub", "topcon"], "a file that does; topcon was taken for the hub"),
    (["run", "topcon_overvoltage.yaml"], "is a scenario: run --scenario topcon_overvoltage.yaml"),
    (["run", "nowhere.yaml"], "nowhere.yaml: No such file or directory"),
    (["run", "topcon"], "(say --interface and --channel, or --hub)"),
    (
        ["run", "topcon", "--nvram", "/nowhere/memory"],
        "there is no directory for it",
    ),
    (
        ["run", "topcon", "-i", "slcan", "-c", "/nowhere", "--real-bus"],
        "the bus cannot be opened: ",
    ),
    (
        ["run", "another", "--scenario", "topcon_overvoltage.yaml"],
        "topcon_overvoltage.yaml is about topcon, not about another",
    ),
]


@pytest.mark.parametrize(("arguments", "told"), WRONG, ids=str)
def test_wrong_input_is_told_in_one_line_and_exit_code_2(said, arguments, told):
    code, out, err = said(*arguments)
    assert (code, out) == (2, "")
    assert err.startswith("canopen-twin: ")
    assert told in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("arguments", [[], ["fly"], ["eds"], ["run", "topcon", "-n", "five"]])
def test_what_is_no_command_is_refused_in_one_line(said, arguments):
    code, out, err = said(*arguments)
    assert (code, out) == (2, "")
    assert err.startswith("canopen-twin")
    assert err.count("\n") == 1


def test_the_version_is_that_of_the_package(said):
    assert said("--version")[:2] == (0, "0.1.0\n")


def test_verbose_may_be_said_before_and_after_the_command(said):
    assert said("-v", "list") == said("list", "-vv")


def test_help_is_there_without_the_imports_of_the_commands():
    code = """if True:
        import sys
        from canopen_twins.cli import parser
        parser().format_help()
        print([name for name in ("can", "canopen", "yaml", "pydantic") if name in sys.modules])
    """
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 0), (signal.SIGINT, 130)])
def test_a_run_says_when_it_is_ready_and_stops_when_it_is_told(number, code):
    with subprocess.Popen(RUN, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        ready = json.loads(run.stdout.readline())
        run.send_signal(number)
        out, err = run.communicate(timeout=60)
    assert ready == {"ready": "topcon", "node_id": 5, "interface": "virtual", "channel": "cli"}
    assert (run.returncode, out, err) == (code, "", "")


def test_a_scenario_beside_a_master_ends_the_run_with_its_verdict(said, tmp_path):
    story = tmp_path / "story.yaml"
    story.write_text("""\
version: 1
node: {device: topcon, node_id: 5}
steps:
  - at: 0.1
    inject: {error: {number: 0x23}}
  - at: 0.1
    expect: {emcy: {code: 0x2300}, within: 0.05}
  - at: 0.2
    expect: {value: {State of output: 0}}
""")
    code, out, _ = said(*RUN[3:], "--scenario", str(story))
    assert code == 1
    assert "FAIL" in out


STORY = """\
version: 1
node: {device: topcon, node_id: 5, settings: {serial: 77}}
steps:
  - at: 0
    expect: {value: {0x1018:04: 77}}
"""
SAVE, STORED = (
    f"version: 1\nnode: {{device: topcon, node_id: 5}}\nsteps:\n  - at: 0\n    {step}\n"
    for step in (
        "write: {0x2010: 1340, 0x1010:01: 0x65766173}",
        "expect: {value: {0x2010: 1340}}",
    )
)


@pytest.fixture
def told(said, tmp_path):
    """Run a scenario beside a master, with further options."""

    def run(story, *options):
        (tmp_path / "story.yaml").write_text(story)
        bus = ["-i", "virtual", "-c", str(tmp_path)]
        return said("run", "topcon", *bus, "--scenario", f"{tmp_path}/story.yaml", *options)

    return run


def test_a_run_takes_the_settings_of_its_scenario_unless_told_otherwise(told):
    assert told(STORY)[0] == 0
    assert told(STORY, "--set", "serial=78")[0] == 1


def test_what_only_a_simulated_bus_can_do_is_left_out_of_a_verdict_in_real_time(told):
    code, out, _ = told("bit_rate: 125000\n" + STORY)
    assert code == 0
    assert "story.yaml: SKIP (1 PASS, 1 SKIP)\n" in out
    assert "story.yaml:1: bit rate of 125000 bit/s: left out: this bus is not simulated" in out


PAIR = """\
version: 1
nodes:
  left: {device: topcon, node_id: 5, settings: {serial: 77}}
  right: {device: charger, node_id: 6}
steps:
  - at: 0
    node: left
    expect: {value: {0x1018:04: 77}}
  - at: 0.05
    node: right
    expect: {value: {0x1000: {min: 0}}}
"""


@pytest.fixture
def run(tmp_path):
    """Run the scenario of a text with no more than it says, and with options."""

    def run(story, *options):
        (tmp_path / "story.yaml").write_text(story)
        bus = ["-i", "virtual", "-c", str(tmp_path)]
        return main(["run", *bus, "--scenario", f"{tmp_path}/story.yaml", *options])

    return run


def test_a_scenario_says_by_itself_who_is_run(run, tmp_path, capsys):
    assert run(STORY) == 0
    ready, *_ = capsys.readouterr().out.splitlines()
    assert json.loads(ready)["ready"] == "topcon"
    assert run(STORY, "--set", "serial=78") == 1


def test_all_nodes_of_a_scenario_are_run(run, tmp_path, capsys):
    assert run(PAIR) == 0
    ready, *_ = capsys.readouterr().out.splitlines()
    assert json.loads(ready)["nodes"] == {"left": 5, "right": 6}
    assert json.loads(ready)["ready"] == f"{tmp_path}/story.yaml"


@pytest.mark.parametrize(
    ("options", "wrong"),
    [
        (["left"], "is about left, right: leave left out, and all of them are run"),
        (["topcon"], "is about left, right, not about topcon"),
        (["-n", "7"], "says all about its nodes: leave --node-id out"),
        (["--nvram", "memory"], "says all about its nodes: leave --nvram out"),
    ],
)
def test_what_does_not_go_with_a_scenario_of_several_is_told(
    run, options, wrong, capsys, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert run(PAIR, *options) == 2
    assert wrong in capsys.readouterr().err


def test_what_a_device_stores_is_there_in_the_next_run(told, tmp_path):
    memory = str(tmp_path / "memory")
    assert told(STORED, "--nvram", memory)[0] == 1
    assert told(SAVE, "--nvram", memory)[0] == 0
    assert told(STORED, "--nvram", memory)[0] == 0


def test_what_a_device_keeps_when_its_supply_goes_is_kept_when_a_run_is_stopped(tmp_path):
    memory, stored = tmp_path / "memory.bin", []

    def look():
        stored.append(memory.read_bytes() if memory.exists() else b"")

    assert run_until_ready("charger", "-i", "virtual", "--nvram", memory, then=look).code == 0
    assert stored != [memory.read_bytes()]


def test_a_memory_belongs_to_one_run_at_a_time(said, tmp_path):
    memory = tmp_path / "memory"
    with held(memory):
        code, _, err = said("run", "topcon", "-i", "virtual", "--nvram", str(memory))
    assert (code, err) == (2, f"canopen-twin: {memory} belongs to another run\n")


def test_a_run_leaves_the_signals_as_they_were(told):
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    told(STORY)
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before
