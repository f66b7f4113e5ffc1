import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from canopen_twins.bus import vcan
from canopen_twins.bus.vcan import guest, process
from canopen_twins.errors import UserError

COMMAND = """
pwd; echo "$GREETING"; echo told >&2
ip -brief link show vcan0 | cut -d' ' -f1
echo kept >out/kept; echo lost >lost
exit 7
"""
VCAN = [sys.executable, "-m", "canopen_twins", "vcan"]

boots = pytest.mark.skipif(
    shutil.which("linux.uml") is None or vcan.is_up(),
    reason="needs user-mode-linux, iproute2 and kmod, and a host without vcan0",
)


@boots
def test_a_command_runs_as_on_the_host_and_only_the_out_folder_is_made_and_kept(tmp_path):
    done = subprocess.run(
        [*VCAN, "--out", "out", "--", "bash", "-c", COMMAND],
        cwd=tmp_path,
        env={**os.environ, "GREETING": "it's here", "PYTHONPATH": str(Path.cwd())},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout == f"{tmp_path}\nit's here\nvcan0\n"
    assert (done.stderr, done.returncode) == ("told\n", 7)
    assert [path.name for path in tmp_path.rglob("*")] == ["out", "kept"]


@boots
def test_what_takes_too_long_is_ended(capsys):
    assert guest.run(["sleep", "1000"], limit=0.5) == 124
    assert capsys.readouterr().err == "stopped after 0.5 s\n"


@boots
def test_the_output_is_live_and_complete_and_sigterm_ends_everything(tmp_path):
    keep = ["--out", str(tmp_path)]  # which is there already
    command = [*VCAN, *keep, "--", "sh", "-c", "seq 100000; exec sleep 1000"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as launcher:
        lines = [launcher.stdout.readline() for _ in range(100000)]
        launcher.send_signal(signal.SIGTERM)
        rest, told = launcher.communicate()  # at the end of the pipes: all who had them are gone
    assert lines == [b"%d\n" % number for number in range(1, 100001)]
    assert (rest, told, launcher.returncode) == (b"", b"", 143)


def test_what_is_missing_is_told_with_the_line_that_installs_it(monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(UserError) as error:
        guest.run(["true"], limit=1.0)
    assert "no linux.uml" in str(error.value)
    assert "apt-get install --no-install-recommends user-mode-linux" in str(error.value)


@boots
def test_the_folder_to_keep_is_made_only_where_its_parent_is(tmp_path):
    with pytest.raises(UserError, match=r"there is no folder: No such file or directory"):
        guest.run(["true"], limit=1.0, out=tmp_path / "nowhere" / "there")


def test_where_vcan0_is_up_the_command_just_runs(capfd):
    assert process.run(["sh", "-c", "echo here; exit 7"], limit=10.0) == 7
    assert process.run(["sh", "-c", "kill -TERM $$"], limit=10.0) == 143
    assert process.run(["sleep", "1000"], limit=0.1) == 124
    assert process.run(["no-such-command"], limit=1.0) == 127
    assert capfd.readouterr() == ("here\n", "stopped after 0.1 s\nno-such-command: not found\n")


@boots
def test_the_how_to_prints_what_it_says(tmp_path):
    page = (Path(__file__).parents[1] / "docs/how-to/run-on-vcan.md").read_text("utf-8")
    name, script = re.search(r"```python file=(\S+)\n(.*?)```", page, re.DOTALL).groups()
    (tmp_path / name).write_text(script, "utf-8")
    command = re.search(r"^canopen-twin vcan -- python (.*)$", page, re.MULTILINE)[1]
    done = subprocess.run(
        [*VCAN, "--", sys.executable, *command.split()],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(Path.cwd())},
        capture_output=True,
        text=True,
        check=False,
    )
    told = [line for line in done.stderr.splitlines() if "stood still" not in line]
    assert (done.returncode, told) == (0, [])  # a guest of a busy machine may stand still
    assert f"This prints `{done.stdout.strip()}`" in page
