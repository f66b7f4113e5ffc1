import os
import re
import shlex
import shutil
import socket
import subprocess
import sys
from pathlib import Path
from textwrap import dedent

import pytest
import yaml

from canopen_twins import scenario as replay
from canopen_twins.bus import vcan
from canopen_twins.cli import parser

DOCS = Path(__file__).parent.parent / "docs"
HUB = DOCS / "how-to" / "join-a-bus-without-vcan.md"
GITHUB, GITLAB = DOCS / "how-to" / "ci-github.md", DOCS / "how-to" / "ci-gitlab.md"
PORT = "29536"


def files(page):
    """The files a page shows, by their names."""
    found = re.findall(r"```\w+ file=(\S+)\n(.*?)```", page.read_text("utf-8"), re.DOTALL)
    return dict(found)


def jobs():
    """The commands of every job that a page shows, and what it has in its environment."""
    for name in (".github/workflows/master.yml", ".github/workflows/master-vcan.yml"):
        for job, told in yaml.safe_load(files(GITHUB)[name])["jobs"].items():
            runs = [step["run"] for step in told["steps"] if "run" in step]
            yield f"github {job}", told["env"], "\n".join(runs)
    for job, told in yaml.safe_load(files(GITLAB)[".gitlab-ci.yml"]).items():
        if job != "default":
            lines = [*told["before_script"], *told["script"]]
            yield f"gitlab {job}", told["variables"], "\n".join(lines)


JOBS = {name: (environment, script) for name, environment, script in jobs()}
AT_THE_END = "trap 'kill $(jobs -p) 2>/dev/null || true' EXIT\n"
INSTALLING = re.compile(r"(pip|apt-get|sudo) ")


def checkout_of(page, folder):
    """The files a page shows, in a folder."""
    for name, text in files(page).items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return folder


@pytest.fixture
def checkout(tmp_path):
    """A project with a master, as the pages show it."""
    return checkout_of(GITHUB, tmp_path)


@pytest.fixture
def port():
    """One that is free: the usual one may belong to somebody."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return str(server.getsockname()[1])


def elsewhere(text, port):
    """The same, with the hub at another port."""
    text = text.replace("canopen-twin hub", f"canopen-twin hub --listen :{port}")
    text = re.sub("--hub(?! --)", f"--hub :{port}", text)  # in front of a command it is its own
    return text.replace(PORT, port)


def carried_out(script, folder, port, **told):
    """What a shell makes of a script, with the hub at another port."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    told = {key: elsewhere(value, port) for key, value in told.items()}
    return subprocess.run(
        ["bash", "-e", "-c", AT_THE_END + elsewhere(script, port)],
        cwd=folder,
        env={**os.environ, "PATH": path, **told},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def shown_by_both(job):
    """The bus in the environment of a job and what it does, which is the same on both services."""
    shown = []
    for service in ("github", "gitlab"):
        told, script = JOBS[f"{service} {job}"]
        bus = {key: value for key, value in told.items() if key.startswith("CAN_")}
        lines = [line for line in script.splitlines() if not INSTALLING.match(line)]
        assert len(lines) < len(script.splitlines())  # what is installed already
        shown.append((bus, lines))
    one, other = shown
    assert one == other
    return one


def test_a_job_with_a_hub_does_what_it_says(checkout, port):
    bus, lines = shown_by_both("twin-on-a-hub")
    assert len(lines) == 6
    done = carried_out("\n".join(lines), checkout, port, **bus)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1 passed" in done.stdout


@pytest.mark.skipif(
    shutil.which("linux.uml") is None and not vcan.is_up(),
    reason="needs a vcan0, or user-mode-linux, iproute2 and kmod",
)
def test_a_job_on_vcan0_does_what_it_says(checkout):
    bus, lines = shown_by_both("twin-on-vcan0")
    assert lines == ["canopen-twin vcan -- sh -eu ci/master.sh"]
    done = carried_out(lines[0], checkout, PORT, **bus)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1 passed" in done.stdout


def test_the_master_of_the_page_about_the_hub_joins_it(tmp_path, port):
    (tmp_path / "master.py").write_text(elsewhere(files(HUB)["master.py"], port))
    _, script = JOBS["github twin-on-a-hub"]
    lines = [line for line in script.splitlines() if line.startswith(("canopen-twin", "timeout"))]
    done = carried_out("\n".join([*lines, "python master.py"]), tmp_path, port)
    assert done.returncode == 0, done.stdout + done.stderr


def commands():
    """Everything the pages tell to canopen-twin."""
    for page in sorted(DOCS.rglob("*.md")):
        text = re.sub(r"\$\{\{.*?\}\}", "1", page.read_text("utf-8"))  # a CI service fills it in
        for line in text.splitlines():
            match = re.match(r"(?:[ -]+|[ -]+run: )?(canopen-twin [^>&|]*)", line)
            if match and "[--" not in line:  # which is no command, but tells how one looks
                yield pytest.param(match[1], id=f"{page.name}: {match[1]}")


@pytest.mark.parametrize("command", list(commands()))
def test_every_command_is_one(command):
    words = shlex.split(command)[1:]
    assert parser().parse_args(words).command


def test_a_bench_file_is_as_its_page_shows_it(tmp_path):
    page = (DOCS / "reference" / "bench-files.md").read_text("utf-8")
    file = tmp_path / "bench.yaml"
    file.write_text(dedent(re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)[0]))
    assert list(replay.load_bench(file)) == ["left", "right"]
