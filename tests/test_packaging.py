import json
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from canopen_twins.bus.hub.protocol import PORT
from canopen_twins.cli import parser

ROOT = Path(__file__).parent.parent
PACKAGING = ROOT / "packaging"
UNIT = PACKAGING / "canopen-twin@.service"
PROGRAM = Path(sys.executable).with_name("canopen-twin")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
SCRIPTS = PROJECT["scripts"]


@pytest.fixture(scope="module")
def unit():
    """The lines of the unit, by their keys."""
    lines = [line.partition("=") for line in UNIT.read_text("utf-8").splitlines() if "=" in line]
    return {key: value for key, _, value in lines if not key.startswith("#")}


@pytest.fixture(scope="module")
def image():
    """The instructions of the Dockerfile."""
    lines = (PACKAGING / "Dockerfile").read_text("utf-8").splitlines()
    return [line.split(" ", 1) for line in lines if line and not line.startswith("#")]


def only(image, instruction):
    (argument,) = (argument for name, argument in image if name == instruction)
    return argument


@pytest.mark.skipif(not shutil.which("systemd-analyze"), reason="there is no systemd-analyze")
def test_systemd_has_nothing_to_say_about_the_unit(tmp_path):
    text = re.sub(r"/opt/\S+/canopen-twin", str(PROGRAM), UNIT.read_text("utf-8"))
    instance = tmp_path / "canopen-twin@vcan0.service"
    instance.write_text(text)
    command = ["systemd-analyze", "verify", "--man=no", instance]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_the_unit_runs_what_the_command_line_knows(unit):
    program, *words = unit["ExecStart"].replace("$OPTIONS", "--real-bus").split()
    options = parser().parse_args([word.replace("%i", "can0") for word in words])
    assert Path(program).name in SCRIPTS
    assert (options.device, options.interface) == ("/etc/canopen-twin/can0.yaml", "socketcan")
    assert (options.channel, options.real_bus) == ("can0", True)


def test_the_unit_comes_and_goes_with_its_interface(unit):
    interface = "sys-subsystem-net-devices-%i.device"
    assert {unit[key] for key in ("BindsTo", "After", "WantedBy")} == {interface}


def test_the_wheel_has_none_of_the_tools_that_write_od_and_docs(tmp_path):
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", tmp_path]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = tmp_path.iterdir()
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {name.split("/")[0].partition("-")[0] for name in names} == {"canopen_twins"}
    assert {name for name in names if name.endswith(("_stories.csv", "charger/eds.py"))} == set()
    assert {f"canopen_twins/od/{path.name}" for path in (ROOT / "od").iterdir()} <= names


def test_the_image_is_built_by_the_first_command_of_the_readme(image):
    readme = re.findall(r"```sh\n(.*?)```", (ROOT / "README.md").read_text("utf-8"), re.DOTALL)
    assert only(image, "RUN") == readme[0].strip()


def test_the_image_runs_a_hub_as_nobody(image):
    assert not only(image, "USER").startswith(("0", "root"))
    (program,) = json.loads(only(image, "ENTRYPOINT"))
    options = parser().parse_args(json.loads(only(image, "CMD")))
    assert program in SCRIPTS
    assert options.listen == f"0.0.0.0:{only(image, 'EXPOSE')}" == f"0.0.0.0:{PORT}"


def test_the_oldest_python_that_is_let_in_is_one_of_those_it_is_run_on():
    named = re.findall(r"Python :: 3\.(\d+)", "\n".join(PROJECT["classifiers"]))
    assert PROJECT["requires-python"] == f">=3.{min(map(int, named))}"
    assert f"{sys.version_info.minor}" in named
