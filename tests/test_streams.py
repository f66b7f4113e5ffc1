import subprocess
import sys

import pytest

COMMAND = f"{sys.executable} -m canopen_twins"


def shell(line):
    """Run a command in a shell: its exit code and what it said on stdout and stderr."""
    done = subprocess.run(line, shell=True, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize("command", ["play topcon_overvoltage.yaml", "list", "schema"])
def test_output_that_finds_no_room_is_told_in_a_line(command):
    told = "canopen-twin: the output cannot be written: No space left on device\n"
    assert shell(f"{COMMAND} {command} > /dev/full") == (2, "", told)


@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-"])
def test_a_stream_that_is_closed_is_written_to_by_nobody(closed):
    code, out, err = shell(f"{COMMAND} play topcon_overvoltage.yaml {closed}")
    assert (code, "PASS" in out, err) == (0, closed == "2>&-", "")


def test_what_is_told_people_does_not_come_among_what_programs_read():
    assert shell(f"{COMMAND} play nothing.yaml 2>&-") == (2, "", "")
