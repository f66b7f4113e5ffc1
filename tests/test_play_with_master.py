"""A master of a file, run as it is while the file is played."""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from canopen_twins import play
from canopen_twins.cli import main
from canopen_twins.errors import UserError
from canopen_twins.scenario import load

STORY = """\
version: 1
name: An interlock opens while a master has switched on
master: {master}
node: {{device: topcon, node_id: 5, settings: {{load: resistor 4}}}}
duration: 5
steps:
  - when: {{write: {{Run command: 1}}}}
    expect: {{value: {{Voltage reference: 2000}}}}
  - after: 1
    inject: {{error: {{number: 0x23}}}}
  - when: {{emcy: {{code: 0x2300}}}}
    expect: {{write: {{Run command: 0}}, within: 0.5}}
"""

MASTER = """\
import os
import random
import sys
import threading
import time
import uuid

seen = []


def main(network, wait=0.1):
    supply = network.add_node(5)
    supply.emcy.add_callback(seen.append)
    supply.nmt.state = "OPERATIONAL"
    supply.sdo.download(0x2010, 0, (2000).to_bytes(2, "little"))
    supply.sdo.download(0x2014, 0, b"\\x01\\x00")
    while not seen:
        time.sleep(wait)
    supply.sdo.download(0x2014, 0, b"\\x00\\x00")


def late(network):
    main(network, 0.9)


def with_arguments(channel, interface="other", **bus):
    assert (channel, interface, bus) == ("can0", "socketcan", {"bitrate": 500_000})
    raise LookupError("as wanted")


def in_a_thread():
    def watch():
        time.sleep(0.5)
        check({})

    threading.Thread(target=watch, name="watch").start()
    time.sleep(2)


def hands_over(network):
    def work():
        time.sleep(0.1)
        main(network)

    threading.Thread(target=work, name="work").start()


def check(values):
    return values["voltage"]


def chance():
    raise LookupError(f"{random.random()} {uuid.uuid4()}")


def wants(eds):
    pass


async def coroutine():
    pass


def leaves():
    raise SystemExit(0)


def generator():
    yield


ENDS = {
    "exit": lambda: sys.exit(3),
    "tells": lambda: sys.exit("no supply"),
    "at_once": lambda: os._exit(0),
    "base": lambda: raise_(type("Gone", (BaseException,), {})()),
    "mute": lambda: raise_(type("Mute", (Exception,), {"__str__": lambda self: 1 / 0})()),
}


def raise_(error):
    raise error


def nameless():
    threading.Thread(target=lambda: check({})).start()


def strays():
    os.chdir("/")
"""


@pytest.fixture
def story(tmp_path, monkeypatch):
    """The path of a story with a master beside it."""
    (tmp_path / "house").mkdir()
    (tmp_path / "house" / "my_master.py").write_text(MASTER)
    monkeypatch.chdir(tmp_path)

    def story(function="main", module="my_master"):
        path = tmp_path / "house" / "story.yaml"
        path.write_text(STORY.format(master=f"{module}:{function}"))
        return path

    return story


def outcomes(verdict):
    return [(str(each.kind), each.line, each.seen) for each in verdict.outcomes]


def test_the_master_of_a_file_lives_through_it(story):
    verdict = play(load(story()))
    assert [kind for kind, *_ in outcomes(verdict)] == ["PASS", "PASS"]
    assert verdict.seconds == pytest.approx(5, abs=1e-3)


def test_a_master_that_reacts_late_fails(story):
    verdict = play(load(story("late")))
    assert [kind for kind, *_ in outcomes(verdict)] == ["PASS", "FAIL"]


def test_threads_keep_the_network_when_its_function_has_returned(story):
    verdict = play(load(story("hands_over")))
    assert [kind for kind, *_ in outcomes(verdict)] == ["PASS", "PASS"]


def test_its_modules_are_new_in_every_run(story):
    scenario = load(story())
    assert play(scenario) == play(scenario)


def test_it_is_looked_for_in_the_working_directory_too(story, tmp_path):
    (tmp_path / "here.py").write_text("from my_master import late as main\n")
    assert not play(load(story(module="here"))).ok


def test_the_command_line_names_another_one(story, capsys):
    path = str(story("late"))
    assert main(["play", path, "--master", "my_master:main"]) == 0
    capsys.readouterr()
    assert main(["play", path, "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["scenarios"][0]["verdict"] == "FAIL"


def test_an_exception_is_told_with_the_innermost_line_of_its_own_files(story):
    verdict = play(load(story("in_a_thread")))
    failed = ("FAIL", 3, "KeyError: 'voltage' in my_master.py:49, thread 'watch'")
    assert failed in outcomes(verdict)
    assert str(verdict.kind) == "FAIL"  # what it did not come to is left out


def test_threads_without_a_name_have_the_same_one_in_every_run(story):
    told = [str(play(load(story("nameless")))) for _ in range(2)]
    assert told[0] == told[1]
    assert "thread 'Thread-1 (<lambda>)'" in told[0]


def test_it_is_given_the_arguments_of_python_can(story):
    assert "LookupError: as wanted in my_master.py:28" in str(play(load(story("with_arguments"))))


def test_chance_is_the_same_in_every_run(story):
    scenario = load(story("chance"))
    first = play(scenario)
    assert "LookupError" in str(first)
    assert first == play(scenario)


def test_who_leaves_by_himself_is_judged_by_the_file_alone(story):
    told = outcomes(play(load(story("leaves"))))
    assert ("ERROR", 7, "its moment never came") in told
    assert not any(line == 3 for _, line, _ in told)


@pytest.mark.parametrize(
    ("end", "seen"),
    [
        ("exit", "SystemExit: 3 in my_master.py:"),
        ("tells", "SystemExit: no supply in my_master.py:"),
        ("at_once", "ExitCalled: os._exit(0) in my_master.py:"),
        ("base", "Gone in my_master.py:"),
        ("mute", "Mute in my_master.py:"),
    ],
)
def test_who_ends_as_no_process_should_has_failed(story, tmp_path, end, seen):
    path = tmp_path / "house" / "my_master.py"
    path.write_text(f"{MASTER}\n\ndef ends():\n    ENDS[{end!r}]()\n")
    (told,) = [each for each in play(load(story("ends"))).outcomes if each.line == 3]
    assert str(told.kind) == "FAIL"
    assert told.seen.startswith(seen)


def test_where_a_master_goes_it_goes_alone(story, tmp_path):
    play(load(story("strays")))
    assert Path.cwd() == tmp_path


def test_it_is_found_beside_its_file_where_the_working_directory_is_deleted(story, tmp_path):
    path = story()
    (tmp_path / "gone").mkdir()
    os.chdir(tmp_path / "gone")  # the fixture goes back
    (tmp_path / "gone").rmdir()
    assert play(load(path)).ok


@pytest.mark.parametrize(
    ("master", "said"),
    [
        ("my_master:maine", "unknown function 'maine': did you mean 'main'?"),
        ("your_master:main", "there is no module 'your_master' here or beside the file"),
        ("my_master:wants", "wants eds: it is called with a canopen.Network, or with interface"),
        ("my_master:coroutine", "coroutine is of asyncio, which has a loop of its own"),
        ("my_master:generator", "generator has a yield in it: a call of it does nothing"),
        ("my_master:seen", "seen is no function"),
        ("broken:main", "cannot be imported: ZeroDivisionError: division by zero"),
        ("needs:main", "cannot be imported: No module named 'nowhere'"),
    ],
)
def test_one_that_cannot_be_run_is_told_in_one_line(story, tmp_path, capsys, master, said):
    (tmp_path / "broken.py").write_text("1 / 0\n")
    (tmp_path / "needs.py").write_text("import nowhere\n")
    assert main(["play", str(story()), "--master", master]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_what_is_no_name_of_a_master_is_wrong_in_the_file(story):
    with pytest.raises(UserError, match=r"story.yaml:3:9: master 'my_master:2': write it as"):
        load(story("2"))


def test_pytest_collects_it_with_its_master(story, pytester):
    (pytester.path / "my_master.py").write_text(MASTER)
    (pytester.path / "late.twin.yaml").write_text(STORY.format(master="my_master:late"))
    (pytester.path / "good.twin.yaml").write_text(STORY.format(master="my_master:main"))
    pytester.runpytest_inprocess("-p", "no:cacheprovider").assert_outcomes(passed=1, failed=1)


HANGS = """\
import threading
import time

lock, other = threading.Lock(), threading.Lock()


def spins():
    while time.monotonic() < 5:
        pass


def deadlock():
    threading.Thread(target=hold, args=(other, lock)).start()
    hold(lock, other)


def hold(first, second):
    with first:
        time.sleep(0.1)
        with second:
            pass
"""


STARVES = """\
import signal
import time


def main():
    while True:
        signal.sigtimedwait([], 0.005)  # in real time, as who waits for a core
        time.sleep(0.0001)
"""


def test_a_run_that_has_hardly_had_a_core_says_nothing_of_its_master(story, tmp_path):
    (tmp_path / "starves.py").write_text(STARVES)
    scenario = load(story("main", "starves"))
    verdict = play(replace(scenario, master=replace(scenario.master, wall=0.1)))
    (told,) = [each for each in verdict.outcomes if each.line == 3]
    assert str(told.kind) == "ERROR"
    assert told.seen.startswith("0.2 s of real time, of which the process had a core for 0.0")


@pytest.mark.parametrize(
    ("function", "seen"),
    [("spins", "a loop asks for the time and never waits"), ("deadlock", "a deadlock of threads")],
)
def test_a_master_that_hangs_fails(story, tmp_path, function, seen):
    (tmp_path / "hangs.py").write_text(HANGS)
    verdict = play(load(story(function, "hangs")))
    (told,) = [each for each in verdict.outcomes if each.line == 3]
    assert (str(told.kind), str(verdict.kind)) == ("FAIL", "FAIL")
    assert told.seen.startswith(seen)
    assert "hangs.py:" in told.seen
