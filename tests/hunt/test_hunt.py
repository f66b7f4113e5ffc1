"""hunt: a contract and a master with a bug, up to the file that shows it."""

import json
import re
import shutil
import subprocess
import sys
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import pytest
import yaml

from canopen_twins.bus.segment import Segment
from canopen_twins.cli import main
from canopen_twins.device.device import Device
from canopen_twins.device.faults import WEATHERS
from canopen_twins.faults import connect
from canopen_twins.faults.weather import WEATHER
from canopen_twins.hunt import free
from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.events import events_of
from canopen_twins.hunt.find import OTHER_HASH_SEED, Trial
from canopen_twins.hunt.search import Budget, Hunt

from .conftest import look_again_here, play_here
from .masters import BRITTLE, CAREFUL, CONTRACT, HASTY


def test_no_more_is_played_than_was_wanted_where_there_is_little_to_try(hunted):
    head, _, tail = CONTRACT.partition("[sdo_silence, power_cycle, heartbeat_stopped]")
    code, said = hunted(CAREFUL, "--runs", "6", "--json", contract=f"{head}[]{tail}")
    assert (code, json.loads(said)["runs"]) == (0, 6)


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_careful_master_is_left_in_peace_for_as_many_runs_as_were_wanted(
    hunted_elsewhere, tmp_path, jobs
):
    code, said = hunted_elsewhere(CAREFUL, "--runs", "20", "--jobs", jobs, "--json")
    told = json.loads(said)
    assert (code, told["runs"], told["finds"]) == (0, 20, [])
    assert not [*tmp_path.glob("hunt-*")]


class Hunted(NamedTuple):
    """What has come of a hunt, and its folder."""

    code: int
    said: str
    folder: Path

    @property
    def texts(self):
        return {file.read_text() for file in self.folder.glob("hunt-*.twin.yaml")}


def hunt(folder, master, *arguments, here=()):
    (folder / "my_master.py").write_text(master)
    (folder / "contract.yaml").write_text(CONTRACT)
    told = ["hunt", "contract.yaml", "--master", "my_master:main", *arguments]
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(StringIO()) as said:
        patch.chdir(folder)
        for stay in here:
            stay(patch)
        code = main(told)
    return Hunted(code, said.getvalue(), folder)


@pytest.fixture(scope="module")
def brittle(tmp_path_factory):
    """A hunt in the process of the tests, with all reports."""
    reports = ["--json", "--junit", "report.xml", "--html", "report.html"]
    folder = tmp_path_factory.mktemp("brittle")
    return hunt(folder, BRITTLE, "--runs", "14", *reports, here=[play_here, look_again_here])


@pytest.fixture(scope="module")
def brittle_of_two(tmp_path_factory):
    """The same in two others, in words."""
    folder = tmp_path_factory.mktemp("brittle")
    return hunt(folder, BRITTLE, "--runs", "14", "--jobs", "2", here=[look_again_here])


@pytest.fixture(scope="module")
def hasty(tmp_path_factory):
    """One in another process."""
    return hunt(tmp_path_factory.mktemp("hasty"), HASTY, "--runs", "8")


def test_what_a_lost_answer_ends_is_found_and_told_with_its_line(brittle_of_two):
    code, said, folder = brittle_of_two
    assert code == 1
    assert re.search(
        "SdoCommunicationError: No SDO response received in my_master.py:(19|20)", said
    )
    find = yaml.safe_load((folder / "hunt-1.twin.yaml").read_text())
    assert find["steps"] == []  # none of the contract matters
    assert len(find["disturbances"]) == 1
    assert "not answered: the fault sdo_silence" in find["note"]


def test_several_processes_find_the_same(brittle, brittle_of_two):
    assert brittle.texts
    assert brittle.texts <= brittle_of_two.texts  # those that were asked for are played


def test_the_report_is_for_programs_for_ci_and_a_page(brittle):
    code, said, folder = brittle
    told = json.loads(said)
    assert (code, told["runs"] >= 14, len(told["finds"]) >= 1) == (1, True, True)
    assert told["finds"][0]["place"] in ("my_master.py:19", "my_master.py:20")
    assert {cell["fault"] for cell in told["cells"]} <= {
        "sdo_silence",
        "power_cycle",
        "heartbeat_stopped",
    }
    cases = ElementTree.parse(folder / "report.xml").iter("testcase")
    failed = [case.get("name") for case in cases if case.find("failure") is not None]
    assert "hunt-1.twin.yaml: master my_master:main" in failed
    page = (folder / "report.html").read_text()
    assert "<th>power_cycle</th>" in page
    assert "class=fail" in page
    assert "disturbances:" in page


def test_a_find_fails_the_same_way_in_play_and_in_another_process(hasty, monkeypatch, capsys):
    monkeypatch.chdir(hasty.folder)
    file = hasty.folder / "hunt-1.twin.yaml"
    assert main(["play", file.name, "--json"]) == 1
    here = json.loads(capsys.readouterr().out)
    there = subprocess.run(
        [sys.executable, "-m", "canopen_twins", "play", file.name, "--json"],
        capture_output=True,
        check=False,
        text=True,
    )
    assert json.loads(there.stdout) == here
    (outcome,) = here["scenarios"][0]["outcomes"]
    assert outcome["what"] == "back within 3 s: Voltage reference 2000, Run command 1"
    find = yaml.safe_load(file.read_text())
    assert "power_cycle" in find["disturbances"][0]["inject"]
    assert find["note"].startswith("The fault power_cycle")
    assert "Expected: back within 3 s: Voltage reference 2000, Run command 1." in find["note"]


def test_a_find_is_there_before_it_is_simple_and_the_same_seed_finds_it(
    here, hasty, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_master.py").write_text(HASTY)
    (tmp_path / "contract.yaml").write_text(CONTRACT)
    seen = []

    def tell(report):
        for find in report.finds:
            seen.append((find.file.name, find.plan.left_out, find.file.read_text() == find.text))

    Hunt(Contract(Path("contract.yaml"), "my_master:main"), budget=Budget(8), tell=tell).hunt()
    assert seen[0] == ("hunt-1.twin.yaml", (), True)
    assert seen[-1] == ("hunt-1.twin.yaml", (0,), True)  # its step does not matter
    assert [path.name for path in tmp_path.glob("*.twin.yaml")] == ["hunt-1.twin.yaml"]
    assert hasty.texts == {(tmp_path / "hunt-1.twin.yaml").read_text()}


def test_finds_of_before_are_played_first_and_not_written_again(hasty, hunted, tmp_path):
    (tmp_path / "finds").mkdir()
    shutil.copy(hasty.folder / "hunt-1.twin.yaml", tmp_path / "finds")
    code, said = hunted(HASTY, "--runs", "9", "--finds", "finds")
    assert (code, "finds/hunt-1.twin.yaml: still fails: back within" in said) == (1, True)
    assert len([*(tmp_path / "finds").iterdir()]) == 1
    code, said = hunted(CAREFUL, "--runs", "2", "--finds", "finds")
    assert (code, "finds/hunt-1.twin.yaml: passes now" in said) == (0, True)


def test_finds_of_another_master_are_left_alone_and_told(hasty, hunted, tmp_path):
    (tmp_path / "finds").mkdir()
    find = (hasty.folder / "hunt-1.twin.yaml").read_text()
    find = find.replace("my_master:main", "another:main")
    (tmp_path / "finds" / "hunt-1.twin.yaml").write_text(find)
    code, said = hunted(CAREFUL, "--runs", "2", "--finds", "finds")
    assert code == 0
    assert "    not played, of another master: finds/hunt-1.twin.yaml\n" in said
    _, told = hunted(CAREFUL, "--runs", "2", "--finds", "finds", "--json")
    assert json.loads(told)["others"] == ["finds/hunt-1.twin.yaml"]


def test_a_contract_needs_no_steps(hunted, tmp_path):
    code, _ = hunted(HASTY, "--runs", "8", contract=CONTRACT.partition("steps:")[0])
    assert code == 1
    find = yaml.safe_load((tmp_path / "hunt-1.twin.yaml").read_text())
    assert (find["steps"], [*find["recovers"]]) == ([], ["within", "when"])
    assert main(["play", "hunt-1.twin.yaml"]) == 1


def test_a_find_says_where_the_master_waits(hunted, tmp_path):
    stuck = CAREFUL.replace("        pass\n", "        time.sleep(1000)\n")
    hunted(stuck, "--runs", "2")
    find = yaml.safe_load((tmp_path / "hunt-1.twin.yaml").read_text())
    assert "The master waits in my_master.py:22 in keep." in find["note"], find["note"]


def test_what_is_another_run_in_another_process_is_no_find(tmp_path):
    told = "__import__('os').environ.get('PYTHONHASHSEED')"
    fickle = BRITTLE.replace("= 0.1", f"= 0.2 if {told} == {OTHER_HASH_SEED!r} else 0.1")
    (tmp_path / "my_master.py").write_text(fickle)
    (tmp_path / "contract.yaml").write_text(CONTRACT)
    contract = Contract(tmp_path / "contract.yaml", "my_master:main")
    report = Hunt(contract, budget=Budget(2), folder=tmp_path).hunt()
    assert report.finds == []
    assert not [*tmp_path.glob("hunt-*")]
    assert report.thrown_away[0].why.startswith("a run in another process differs: ")


def test_a_master_that_spins_is_a_find_too(hunted, tmp_path):
    spins = CAREFUL.replace("        pass\n", "        while True:\n            time.monotonic()\n")
    code, said = hunted(spins, "--runs", "2")
    assert (code, "a loop asks for the time and never waits, at " in said) == (1, True)
    assert "in my_master.py:23\n" in said


def test_the_free_search_depends_on_its_seed_alone(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_master.py").write_text(CAREFUL)
    (tmp_path / "contract.yaml").write_text(CONTRACT)
    contract = Contract(Path("contract.yaml"), "my_master:main")
    events, _ = events_of(contract, contract.scenario(Plan()))

    def played(seed):
        batch = free.Batch(contract, events, seed, frozenset(), frozenset(), runs=12)
        results = free.search(batch)
        return [(result.plan.key, result.trace) for result in results]

    assert played(1) == played(1) != played(2)


def test_what_another_hunt_has_not_finished_is_no_find_of_before(hunted, tmp_path, monkeypatch):
    (tmp_path / "finds").mkdir()
    kept = Trial.keep
    others = []

    def keep(trial, place):
        others.append(hunted(CAREFUL, "--runs", "1", "--finds", "finds"))
        (tmp_path / "my_master.py").write_text(BRITTLE)
        return kept(trial, place)

    monkeypatch.setattr(Trial, "keep", keep)
    hunted(BRITTLE, "--runs", "2", "--finds", "finds")
    code, said = others[0]
    assert (code, "passes now" in said) == (0, False), said


TEST = """\
import my_master


def test_it_survives(canopen_hunt):
    report = canopen_hunt("contract.yaml", my_master.main, runs=6)
    assert report.runs >= 6
"""


@pytest.fixture
def tested(pytester):
    """What comes of a test of a master with the fixture, and what it has found."""

    def tested(master):
        pytester.makepyfile(my_master=master, test_it=TEST)
        (pytester.path / "contract.yaml").write_text(CONTRACT)
        (pytester.path / "finds").mkdir()
        result = pytester.runpytest_inprocess("-p", "no:cacheprovider", "test_it.py")
        return result, [*(pytester.path / "finds").glob("*.twin.yaml")]

    return tested


def test_the_fixture_leaves_a_careful_master_in_peace(tested):
    result, finds = tested(CAREFUL)
    result.assert_outcomes(passed=1)
    assert finds == []


def test_the_fixture_fails_with_what_it_finds(here, tested, pytester):
    result, finds = tested(BRITTLE)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*hunt-1.twin.yaml: master my_master:main: *", "disturbances:"])
    assert finds
    again = pytester.runpytest_inprocess("-p", "no:cacheprovider", *map(str, finds))
    again.assert_outcomes(failed=len(finds))  # and is a test from now on


def test_one_that_is_interrupted_tells_what_it_has_found(hunted, tmp_path, monkeypatch):
    plans = iter([False] * 6)
    whole = Hunt._take

    def take(self, result):
        whole(self, result)
        if next(plans, True):
            raise KeyboardInterrupt

    monkeypatch.setattr(Hunt, "_take", take)
    code, said = hunted(CAREFUL, "--runs", "1000", "--html", "hunt.html")
    assert (code, "0 finds in 8 runs" in said) == (130, True)
    assert (tmp_path / "hunt.html").is_file()


def test_the_tutorial_shows_what_is_found(hunted, tmp_path):
    page = Path(__file__).parents[2] / "docs" / "tutorial-hunt.md"
    shown = dict(re.findall(r"```\w+ file=(\S+)\n(.*?)```", page.read_text("utf-8"), re.DOTALL))
    contract = shown["contract.yaml"]
    _, said = hunted(shown["holder.py"], "--runs", "5", contract=contract)
    assert f"```text\n{''.join(said.splitlines(keepends=True)[:2])}```" in page.read_text("utf-8")
    shown = re.findall(r"```yaml\n(disturbances:\n.*?)```", page.read_text("utf-8"), re.DOTALL)
    assert shown[0] in (tmp_path / "hunt-1.twin.yaml").read_text()


def test_every_fault_of_every_device_says_in_which_weather_it_comes():
    known = connect(Segment(), Device(), "").faults.known
    assert known.keys() == WEATHER.keys()
    assert {weather.least for weather in WEATHER.values()} <= set(WEATHERS)


COMMAND = """\
import sys
import time

import can

with can.Bus() as bus:  # where it is says the environment
    while True:
        bus.send(can.Message(arbitration_id=0x605, data=bytes.fromhex("4023200000000000"),
                             is_extended_id=False))
        answer = bus.recv(1.0)
        while answer is not None and answer.arbitration_id != 0x585:
            answer = bus.recv(1.0)
        if answer is None or answer.data[0] == 0x80:
            sys.exit(3)
        time.sleep(0.05)
"""


def test_a_master_of_any_language_is_hunted_in_real_time(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "master.py").write_text(COMMAND)
    (tmp_path / "contract.yaml").write_text("""\
version: 1
node: {device: topcon, node_id: 5}
duration: 2
space: {faults: [sdo_abort]}
steps:
  - at: 0
    expect: {frame: "605#40*", from: master, within: 5}
""")
    command = [sys.executable, "master.py"]
    assert main(["hunt", "contract.yaml", "--runs", "1", "--", *command]) == 1
    assert "master.py: has ended with exit code 3" in capsys.readouterr().out
    (find,) = tmp_path.glob("hunt-*.twin.yaml")
    assert "master" not in yaml.safe_load(find.read_text())
    code = main(["run", "--scenario", find.name, "--hub", "--", *command])
    assert (code, "has ended with exit code 3" in capsys.readouterr().out) == (1, True)


def test_a_find_takes_a_name_that_nobody_has_and_leaves_nothing_else(hunted, tmp_path):
    (tmp_path / "hunt-1.twin.yaml").write_text("somebody's\n")
    assert hunted(BRITTLE, "--runs", "2")[0] == 1
    assert (tmp_path / "hunt-1.twin.yaml").read_text() == "somebody's\n"
    names = {path.name for path in tmp_path.glob("*.twin.yaml")}
    assert "hunt-2.twin.yaml" in names
    assert not {name for name in names if name.startswith(".")}
