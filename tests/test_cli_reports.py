import json
import subprocess
import sys
from xml.etree import ElementTree

import pytest

from canopen_twins.cli import main

STORY = """\
version: 1
name: {name}
node: {{device: topcon, node_id: 5}}
steps:
  - at: 0.1
    expect: {{value: {{Nominal voltage: {volts}}}}}
"""
RUN = ["run", "topcon", "-i", "virtual", "-c", "reports"]


@pytest.fixture
def story(tmp_path):
    """Write a file, and say where it is."""

    def story(name, volts=400):
        path = tmp_path / f"{name}.yaml"
        path.write_text(STORY.format(name=name, volts=volts))
        return str(path)

    return story


@pytest.fixture
def said(capsys):
    """Run a command: exit code, stdout, stderr."""

    def said(*arguments):
        return main(arguments), *capsys.readouterr()

    return said


def suites(path):
    return [
        (suite.get("name"), suite.get("tests"), suite.get("failures"), suite.get("errors"))
        for suite in ElementTree.parse(path).iter("testsuite")
    ]


def test_play_writes_a_suite_for_every_file_beside_what_it_says_to_people(said, story, tmp_path):
    good, bad, report = story("good"), story("bad", 401), tmp_path / "report.xml"
    assert said("play", good, bad, "--junit", str(report)) == said("play", good, bad)
    assert suites(report) == [("good", "1", "0", "0"), ("bad", "1", "1", "0")]


def test_play_says_one_document_to_programs_and_nothing_else(said, story):
    code, out, err = said("play", story("good"), story("bad", 401), "--json")
    assert (code, err) == (1, "")
    told = json.loads(out)
    assert [each["verdict"] for each in told["scenarios"]] == ["PASS", "FAIL"]
    assert told["scenarios"][1]["outcomes"][0]["seen"] == "Nominal voltage is 400"


def test_it_is_the_same_each_time(said, story, tmp_path):
    bad, reports = story("bad", 401), [tmp_path / "1.xml", tmp_path / "2.xml"]
    said_twice = [said("play", bad, "--json", "--junit", str(report)) for report in reports]
    assert said_twice[0] == said_twice[1]
    assert reports[0].read_bytes() == reports[1].read_bytes()


def test_run_reports_what_its_scenario_came_to(said, story, tmp_path):
    report = tmp_path / "report.xml"
    bad = story("bad", 401)
    code, out, _ = said(*RUN, "--scenario", bad, "--json", "--junit", str(report))
    ready, document = map(json.loads, out.splitlines())
    assert (code, ready["ready"], document["verdict"]) == (1, "topcon", "FAIL")
    assert suites(report) == [("bad", "1", "1", "0")]


def test_run_reports_a_scenario_that_was_stopped_as_one_that_says_nothing(tmp_path, story):
    late = tmp_path / "late.yaml"
    late.write_text(STORY.format(name="late", volts=400).replace("0.1", "1000"))
    report = tmp_path / "report.xml"
    command = [sys.executable, "-m", "canopen_twins", *RUN, "--scenario", late, "--junit", report]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        process.stdout.readline()
        process.terminate()
        out, _ = process.communicate(timeout=30)
    assert process.returncode == 1
    assert "ERROR (1 ERROR)" in out
    assert suites(report) == [("late", "1", "0", "1")]


@pytest.mark.parametrize("option", [["--json"], ["--junit", "report.xml"]])
def test_run_without_a_scenario_has_no_verdict(said, option):
    code, out, err = said(*RUN, *option)
    assert (code, out) == (2, "")
    assert err == (
        "canopen-twin: --json and --junit tell of a verdict: say which with --scenario\n"
    )


def test_a_report_that_has_no_place_is_refused_before_anything_is_played(said, story):
    code, out, err = said("play", story("good"), "--junit", "/nowhere/report.xml")
    assert (code, out) == (2, "")
    assert err == "canopen-twin: /nowhere/report.xml: there is no directory for it\n"


def test_a_report_that_is_a_directory_is_refused_before_anything_is_played(said, story, tmp_path):
    told = f"canopen-twin: {tmp_path} is a directory, where a plain file is wanted\n"
    assert said("play", story("good"), "--junit", str(tmp_path)) == (2, "", told)


def test_a_report_that_cannot_be_written_is_told(said, story):
    code, _, err = said("play", story("good"), "--junit", "/proc/report.xml")
    assert code == 2
    assert err.startswith("canopen-twin: /proc/report.xml cannot be written: ")
