"""Masters that end their process, hang in it, or leave something behind."""

import json
import re
import signal
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
import yaml

from canopen_twins import play
from canopen_twins.hunt import workers
from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.free import Batch, search, suspects
from canopen_twins.hunt.report import Report, ThrownAway, as_html, as_json, lines
from canopen_twins.hunt.run import difference, run, run_to_compare
from canopen_twins.hunt.search import first_run, lost
from canopen_twins.hunt.workers import Death, Pool

from .masters import CAREFUL, CONTRACT

CRASHES = CAREFUL.replace("        pass\n", "        __import__('ctypes').string_at(0)\n")
"""A lost answer ends its process by SIGSEGV."""


@pytest.fixture
def believed(monkeypatch):
    """Two deaths are enough, of a third of a second each; test_workers.py has all that it takes."""
    monkeypatch.setattr(workers, "DEATHS", 2)


@pytest.mark.timeout(300)
def test_a_plan_that_ends_the_process_of_its_master_is_a_find(believed, hunted_elsewhere, tmp_path):
    (tmp_path / "finds").mkdir()
    short = CONTRACT.partition("steps:")[0]  # each of its parts is a death more
    code, said = hunted_elsewhere(CRASHES, "--runs", "2", "--finds", "finds", contract=short)
    assert code == 1
    told = "has ended its process: SIGSEGV in my_master.py:22"
    assert f"finds/hunt-1.twin.yaml: master my_master:main: {told}\n" in said
    file = tmp_path / "finds" / "hunt-1.twin.yaml"
    find = yaml.safe_load(file.read_text())
    assert len(find["disturbances"]) == 1
    assert f"The master {told}. Whoever plays this file ends with it." in find["note"]

    command = [sys.executable, "-m", "canopen_twins", "play", str(file)]
    done = subprocess.run(command, capture_output=True, check=False, text=True)
    assert done.returncode == -signal.SIGSEGV
    assert 'my_master.py", line 22 in keep' in done.stderr

    code, said = hunted_elsewhere(CRASHES, "--runs", "1", "--finds", "finds", contract=short)
    assert (code, "still fails: master my_master:main: has ended" in said) == (1, True)


def test_no_hunt_begins_with_a_master_that_always_ends_its_process(believed, hunted_elsewhere):
    code, said = hunted_elsewhere(
        CRASHES.replace("while True:", "while __import__('ctypes').string_at(0):"), "--runs", "3"
    )
    assert (code, "without any fault this master ends its process: SIGSEGV in my" in said) == (
        2,
        True,
    )


def contract(tmp_path, master, text=CONTRACT, name="contract"):
    (tmp_path / "my_master.py").write_text(master)
    (tmp_path / f"{name}.yaml").write_text(text)
    return Contract(tmp_path / f"{name}.yaml", "my_master:main")


FAULTS = "[sdo_silence, power_cycle, heartbeat_stopped]"
HARMLESS = "heartbeat_stopped, boot_up_repeated, emcy_doubled, emcy_lost"


@pytest.mark.timeout(300)
def test_a_drawn_plan_that_ends_its_process_is_told_apart_from_its_batch(believed, tmp_path):
    def batch(name, faults, runs):
        tested = contract(tmp_path, CRASHES, CONTRACT.replace(FAULTS, f"[{faults}]"), name)
        events, _ = first_run(tmp_path, tested)
        return Batch(tested, events, 1, frozenset(), frozenset(), runs, place=tmp_path / name)

    goes_on, dies = batch("goes_on", f"sdo_silence, {HARMLESS}", 1), batch("dies", "sdo_silence", 9)
    with Pool(1, lost) as pool:
        results, death = pool(search, [goes_on, dies])
        deadly = suspects(goes_on.place)
        assert deadly
        assert all(each.death for each in pool(partial(run, goes_on.contract), deadly))
    assert results
    assert not {each.plan.key for each in results} & {plan.key for plan in deadly}
    assert (type(death), len(suspects(dies.place))) == (Death, workers.DEATHS)


def begins_with(line):
    return CAREFUL.replace("    while True:\n", f"    import os\n    {line}\n    while True:\n")


SPAWNS = begins_with('os.posix_spawnp("sh", ["sh", "-c", "sleep 1001 & sleep 1002"], os.environ)')
FORKS = begins_with("os.fork()")


def running():
    """The processes that have begun with us, in words."""
    lines = subprocess.run(
        ["ps", "-e", "-o", "args"], check=True, capture_output=True, text=True
    ).stdout
    return [line for line in lines.splitlines() if "sleep 100" in line]


@pytest.mark.parametrize(("master", "told"), [(SPAWNS, "sleep 1001"), (FORKS, "python")])
def test_processes_that_a_master_leaves_behind_are_ended_and_told(tmp_path, master, told):
    verdict = play(contract(tmp_path, master).scenario(Plan()))
    (outcome,) = [each for each in verdict.outcomes if "left processes behind" in each.seen]
    assert verdict.ok
    assert told in outcome.seen
    assert not running()


def test_a_hunt_tells_of_them_too(hunted):
    _, said = hunted(SPAWNS, "--runs", "2")
    assert "the master has left processes behind in 2 runs: they were ended" in said


DELETES = CAREFUL.replace("canopen.SdoCommunicationError", "canopen.SdoAbortedError").replace(
    "    while True:\n",
    """    import os, shutil, tempfile

    os.chdir(tempfile.mkdtemp())
    os.rmdir(os.getcwd())
    shutil.rmtree(FOLDER, ignore_errors=True)
    while True:
""",
)


def test_a_master_that_deletes_its_directory_keeps_no_find_from_being_written(
    hunted_elsewhere, tmp_path
):
    (tmp_path / "finds").mkdir()
    deletes = f"FOLDER = {str(tmp_path / 'finds')!r}\n{DELETES}"
    code, said = hunted_elsewhere(deletes, "--runs", "2", "--finds", "finds")
    assert (code, (tmp_path / "finds" / "hunt-1.twin.yaml").is_file()) == (1, True), said


def test_two_runs_differ_in_their_first_other_frame(tmp_path):
    tested = contract(tmp_path, CAREFUL)
    one = run_to_compare(tested, Plan())
    other = run_to_compare(tested, Plan(({"at": 0.2, "inject": "heartbeat_stopped"},)))
    assert difference(one, one) == ""
    told = difference(one, replace(one, frames=one.frames[:2]))
    assert re.fullmatch(r"\S+ of \S.* at 0\.\d{6} s; nothing more", told), told
    frames = (*one.frames[:1], "1500000 705#7F topcon\n", *one.frames[2:])
    told = difference(one, replace(one, frames=frames))
    assert told.endswith("; 705#7F of topcon at 1.500000 s"), told
    assert difference(one, replace(one, error="no end in 120 s")) == "no end in 120 s"
    assert bool(difference(one, other)) == (one.frames != other.frames)


def test_what_has_not_failed_again_is_told_in_every_report():
    report = Report(Contract(Path("contract.yaml")), 1)
    plan = Plan(({"at": 0.2, "inject": "heartbeat_stopped"},))
    report.thrown_away.append(ThrownAway(plan, "two runs of it differ: <here>"))
    assert "    thrown away: heartbeat_stopped: two runs of it differ: <here>" in lines(report)
    assert "two runs of it differ: &lt;here&gt;" in as_html(report)
    (told,) = json.loads(as_json(report))["unequal"]
    assert told == {"faults": ["heartbeat_stopped"], "why": "two runs of it differ: <here>"}
