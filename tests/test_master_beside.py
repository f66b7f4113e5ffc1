"""A master that `run` starts beside the twins: where it finds the bus, and how a run ends."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest

from canopen_twins.cli import main
from canopen_twins.live.master_process import BusPlace, MasterProcess

PATIENCE = 30.0
PROGRAM = [sys.executable, "-m", "canopen_twins"]
PLACE = BusPlace("socketcan", "vcan7")
HEADER = "version: 1\nnode: {device: topcon, node_id: 5}\n"
UNTIL_RUN = f"""{HEADER}steps:
  - at: 0
    note: it runs in time
    expect: {{write: {{Run command: 1}}, within: 10}}
"""
MASTER = """\
import can, canopen, sys, time
with can.Bus() as bus:
    print("on", bus.channel_info, flush=True)
    bus.send(can.Message(arbitration_id=0x605, is_extended_id=False, data={data}))
    assert bus.recv(30).arbitration_id == 0x585
    {then}
"""
RUN_COMMAND = list(bytes.fromhex("2B14200001000000"))


@pytest.fixture
def beside(tmp_path, capfd, monkeypatch):
    """Run a scenario on a hub of its own with a Python program beside it."""
    monkeypatch.chdir(tmp_path)

    def beside(story, program, *options):
        (tmp_path / "story.yaml").write_text(story)
        (tmp_path / "master.py").write_text(program)
        command = (sys.executable, "master.py", "{interface}", "{channel}", "{hub}")
        scenario = ("--scenario", "story.yaml") if story else ("topcon", "-n", "5")
        code = main(["run", *scenario, "--hub", *options, "--", *command])
        return code, *capfd.readouterr()

    return beside


def program(then="", data=RUN_COMMAND):
    return MASTER.format(then=then, data=data)


def test_a_master_without_arguments_finds_the_hub_of_the_run_and_ends_with_the_scenario(beside):
    code, out, err = beside(UNTIL_RUN, program("time.sleep(60)"))
    ready, *said = out.splitlines()
    assert json.loads(ready).keys() == {"ready", "node_id", "hub", "channel"}
    assert json.loads(ready)["hub"] in said[0]
    assert said[1] == "story.yaml: PASS (1 PASS)"
    assert (code, err) == (0, "")


def test_a_master_that_fails_is_an_error_of_the_run(beside, tmp_path):
    code, out, _ = beside(UNTIL_RUN, "raise SystemExit(3)", "--junit", "report.xml")
    assert code == 1
    assert "story.yaml: ERROR (1 SKIP, 1 ERROR)" in out
    command = f"the command {sys.executable} master.py {{interface}} {{channel}} {{hub}}"
    assert f"story.yaml: {command}: has ended with exit code 3\n" in out
    suites = ElementTree.parse(tmp_path / "report.xml").getroot()
    assert (suites.get("errors"), suites.get("failures")) == ("1", "0")
    assert suites.find(".//error").get("message") == "has ended with exit code 3"
    names = [case.get("name") for case in suites.iter("testcase")]
    assert names == [command, "topcon: it runs in time"]


WHILE_COMMAND = f"""{HEADER}ends_with: command
steps:
  - at: 0
    expect: {{never: {{write: {{Run command: 0}}}}}}
"""


def test_a_run_that_ends_with_its_command_is_judged_up_to_there(beside):
    code, out, _ = beside(WHILE_COMMAND, program())
    assert (code, "no write Run command = 0" in out) == (0, True)
    code, out, _ = beside(WHILE_COMMAND, program(data=list(bytes.fromhex("2B14200000000000"))))
    assert (code, "FAIL" in out) == (1, True)


def test_what_the_command_did_not_wait_for_is_an_error(beside):
    later = "  - at: 3600\n    set: {load: open}\n"
    code, out, _ = beside(UNTIL_RUN.replace("steps", "ends_with: command\nsteps") + later, "pass")
    assert code == 1
    assert "story.yaml:5: topcon: write Run command = 1 within 10 s: the run ended before" in out
    assert "story.yaml:8: topcon: set: 1 step from here on was not reached" in out


def test_without_a_scenario_the_exit_code_is_that_of_the_command(beside):
    assert beside("", program("sys.exit(7)"))[0] == 7
    assert beside("", "import os; os.kill(os.getpid(), 9)")[0] == 128 + 9


def test_what_cannot_be_run_is_told_in_one_line(beside, capfd):
    assert main(["run", "topcon", "-n", "5", "--hub", "--", "no-such-program"]) == 2
    out, err = capfd.readouterr()
    assert (out, "no-such-program: no such program, or none that may be run" in err) == ("", True)
    with pytest.raises(SystemExit, match="2"):
        main(["run", "topcon", "--hub", "--"])
    assert "canopen-twin run: a COMMAND is wanted behind --" in capfd.readouterr().err
    assert main(["run", "topcon", "-i", "virtual", "--", "true"]) == 2
    assert "no other process can join a virtual bus: say --hub" in capfd.readouterr().err
    with pytest.raises(ValueError, match=r"asks for {hub}, but this run is on none"):
        PLACE.filled(["master", "{hub}"])


def test_a_command_says_where_it_wants_the_bus():
    assert PLACE.filled(["{interface}:{channel}", "{x}"]) == ["socketcan:vcan7", "{x}"]
    assert PLACE.environment == {"CAN_INTERFACE": "socketcan", "CAN_CHANNEL": "vcan7"}


STUBBORN = "trap '' TERM; sleep 60 & echo $!; wait"  # what is ignored is so in children, too


def test_a_master_that_does_not_end_is_killed_with_all_that_it_has_started(tmp_path):
    with (tmp_path / "said").open("w+") as said:
        with MasterProcess(["sh", "-c", STUBBORN], PLACE, grace=0.1, stdout=said) as master:
            while not (child := (tmp_path / "said").read_text()).endswith("\n"):
                time.sleep(0.01)
            assert not master.gone
        assert master.gone
    assert (master.code, master.failure) == (-signal.SIGKILL, "")
    assert is_over(int(child))


def is_over(process_id):
    """Whether a process has ended, even if nobody has taken notice of it."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        try:
            if Path(f"/proc/{process_id}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
                return True
        except FileNotFoundError:
            return True
        time.sleep(0.01)
    return False


def test_a_run_and_its_hub_end_when_the_parent_does(tmp_path):
    code = (
        "import subprocess, sys, time\n"
        "run = subprocess.Popen(sys.argv[1:], stdout=subprocess.PIPE, text=True)\n"
        "print(run.pid, run.stdout.readline(), flush=True)\n"
        "time.sleep(60)\n"
    )
    run = [*PROGRAM, "run", "topcon", "-n", "5", "--nvram", str(tmp_path / "memory"), "--hub"]
    arguments = [*run, "--", sys.executable, "-c", "import time; time.sleep(60)"]
    with subprocess.Popen(
        [sys.executable, "-c", code, *arguments], stdout=subprocess.PIPE, text=True
    ) as parent:
        process_id, ready = parent.stdout.readline().split(" ", 1)
        port = json.loads(ready)["hub"].partition(":")[2]
        parent.kill()
    assert is_over(int(process_id))
    again = ["hub", "--listen", f"127.0.0.1:{port}", "--parent", str(parent.pid)]
    assert main(again) == 2  # there is no such parent any more


def test_a_hub_ends_when_its_parent_does():
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as parent:
        command = [*PROGRAM, "hub", "--listen", "127.0.0.1:0", "--parent", str(parent.pid)]
        with subprocess.Popen(command, stdout=subprocess.PIPE) as hub:
            assert json.loads(hub.stdout.readline())["ready"] == "hub"
            parent.communicate(b"\n")
            assert hub.wait(PATIENCE) == 0


@pytest.mark.parametrize(
    ("number", "story", "code"),
    [
        (signal.SIGTERM, UNTIL_RUN, 1),
        (signal.SIGINT, UNTIL_RUN, 130),
        (signal.SIGINT, UNTIL_RUN + "  - at: 0\n    expect: {value: {0x1000: {min: 0}}}\n", 1),
    ],
)
def test_the_exit_code_is_that_of_the_verdict_whatever_ended_the_run(number, story, code, tmp_path):
    (tmp_path / "story.yaml").write_text(story)
    run = [*PROGRAM, "run", "-i", "virtual", "--scenario", str(tmp_path / "story.yaml")]
    with subprocess.Popen(run, stdout=subprocess.PIPE, text=True) as process:
        process.stdout.readline()
        time.sleep(0.3)
        os.kill(process.pid, number)
        out, _ = process.communicate(timeout=PATIENCE)
    assert "ERROR" in out
    assert process.returncode == code
