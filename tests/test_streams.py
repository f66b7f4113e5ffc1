import json
import signal
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from canopen_twins.cli import main

COMMAND = f"{sys.executable} -m canopen_twins"


def shell(line):
    """Run a command in a shell: its exit code and what it said on stdout and stderr."""
    done = subprocess.run(line, shell=True, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


NO_ROOM = "canopen-twin: the output cannot be written: No space left on device\n"


def test_output_that_finds_no_room_is_told_in_a_line():
    assert shell(f"{COMMAND} play topcon_overvoltage.yaml > /dev/full") == (2, "", NO_ROOM)


@pytest.mark.parametrize("command", ["list", "schema"])
def test_every_command_tells_it_so(command, monkeypatch, capsys):
    with Path("/dev/full").open("w") as full:
        monkeypatch.setattr(sys, "stdout", full)
        assert main([command]) == 2
    assert capsys.readouterr().err == NO_ROOM


@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-"])
def test_a_stream_that_is_closed_is_written_to_by_nobody(closed):
    code, out, err = shell(f"{COMMAND} play topcon_overvoltage.yaml {closed}")
    assert (code, "PASS" in out, err) == (0, closed == "2>&-", "")


def test_what_is_told_people_does_not_come_among_what_programs_read():
    assert shell(f"{COMMAND} play nothing.yaml 2>&-") == (2, "", "")


STORY = """\
version: 1
name: Übertemperatur
node: {device: topcon, node_id: 5}
steps:
  - {at: SECONDS, expect: {value: {Nominal voltage: 400}}, note: "größer → kleiner"}
"""


def story(folder, seconds):
    file = folder / "grün.yaml"
    file.write_text(STORY.replace("SECONDS", str(seconds)), "utf-8")
    return file


def test_a_verdict_is_written_to_a_stdout_that_is_no_utf_8(tmp_path):
    report = tmp_path / "report.xml"
    command = f"PYTHONIOENCODING=ascii {COMMAND}"
    played = shell(f"{command} play {story(tmp_path, 0.1)} --junit {report}")
    assert (played[0], played[2]) == (0, "")
    assert r"gr\xfcn.yaml: PASS" in played[1]
    assert ElementTree.parse(report).getroot().find(".//testsuite").get("name") == "Übertemperatur"


@pytest.mark.parametrize("words", ["--version", "run --help", "objects topcon"])
def test_a_reader_that_has_seen_enough_is_no_error(words):
    process = subprocess.Popen(
        [*COMMAND.split(), *words.split()], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    process.stdout.close()  # before anything is written
    assert process.stderr.read() == b""
    process.stderr.close()
    assert process.wait() in {0, 141}


def test_a_hang_up_ends_a_run_as_sigterm_does_with_its_verdict_and_its_report(tmp_path):
    report = tmp_path / "report.xml"
    words = ["run", "topcon", "-i", "virtual", "--scenario", story(tmp_path, 1000)]
    command = [*COMMAND.split(), *words, "--junit", report]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert "ready" in json.loads(process.stdout.readline())
        process.send_signal(signal.SIGHUP)
        out, err = process.communicate(timeout=30)
    assert (process.returncode, err) == (1, b"")  # as in test_cli_reports.py
    assert b"ERROR (1 ERROR)" in out
    assert report.is_file()


def test_a_hang_up_that_is_ignored_stays_so():
    command = f"trap '' HUP; exec {COMMAND} run topcon -i virtual"
    with subprocess.Popen(["sh", "-c", command], stdout=subprocess.PIPE) as process:
        assert process.stdout.readline()
        process.send_signal(signal.SIGHUP)
        process.terminate()
        assert process.wait(30) == 0


CONFIGURED = {
    "CAN_CONFIG": ("[]", "CAN_CONFIG is a JSON object of options of python-can, not []"),
    "HOME": ("interface = virtual\n", "File contains no section headers"),
}


@pytest.mark.parametrize("variable", CONFIGURED)
def test_a_configuration_of_python_can_that_is_none_is_told_in_one_line(
    tmp_path, monkeypatch, capsys, variable
):
    content, told = CONFIGURED[variable]
    (tmp_path / ".canrc").write_text(content)
    monkeypatch.setenv(variable, str(tmp_path) if variable == "HOME" else content)
    assert main(["run", "topcon"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert told in line


@pytest.mark.parametrize("limit", ["nan", "inf", "-1", "0", "soon"])
def test_a_limit_that_is_no_time_is_told_in_one_line(limit, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["vcan", "--limit", limit, "--", "true"])
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert f"a time is a number of seconds above 0, not '{limit}'" in err
