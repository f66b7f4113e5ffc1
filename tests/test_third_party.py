import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from canopen_twins.devices import GROUP

ROOT = Path(__file__).parent.parent
EXAMPLE = ROOT / "docs" / "examples" / "canopen-fan"
PAGE = ROOT / "docs" / "how-to" / "add-a-device.md"
SHOWN = dict(re.findall(r"```\w+ file=(\S+)\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL))


def install(folder, project):
    """What an installer leaves of a project in a folder of packages: its metadata."""
    told = project["project"]
    info = folder / f"{told['name'].replace('-', '_')}-{told['version']}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {told['name']}\nVersion: {told['version']}\n"
    )
    groups = told["entry-points"].items()
    lines = [
        f"[{group}]\n{name} = {what}\n" for group, told in groups for name, what in told.items()
    ]
    (info / "entry_points.txt").write_text("".join(lines))


def project(name, devices):
    """One that brings devices."""
    return {"project": {"name": name, "version": "1", "entry-points": {GROUP: devices}}}


@pytest.fixture
def packages(tmp_path):
    """A folder of packages with the fan in it."""
    shutil.copytree(EXAMPLE / "canopen_fan", tmp_path / "canopen_fan")
    install(tmp_path, tomllib.loads((EXAMPLE / "pyproject.toml").read_text("utf-8")))
    return tmp_path


@pytest.fixture
def python(packages):
    """Runs a module where the folder is among the packages."""
    path = os.pathsep.join([str(packages), str(ROOT)])

    def python(*arguments, folder=EXAMPLE):
        return subprocess.run(
            [sys.executable, "-m", *map(str, arguments)],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"},
            capture_output=True,
            text=True,
            check=False,
        )

    return python


def test_a_device_that_is_installed_is_listed_with_the_others(python):
    listed = python("canopen_twins", "list")
    assert (listed.returncode, listed.stderr) == (0, "")
    assert "\nfan      Example fan with CANopen speed controller\n" in listed.stdout
    assert listed.stdout.startswith("charger ")


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("eds", "ParameterName=Actual speed"),
        ("objects", "0x2000:00  Target speed"),
        ("settings", "time_constant"),
        ("faults", "blocked"),
    ],
)
def test_every_command_knows_it(python, command, told):
    assert told in python("canopen_twins", command, "fan").stdout


def test_its_story_is_played(python):
    played = python("canopen_twins", "play", "--raw", "fan_blocked.twin.yaml")
    assert played.returncode == 0, played.stdout + played.stderr
    assert "(0000000006.000000) can0 089#2171810000000000\n" in played.stdout
    assert "fan_blocked.twin.yaml: PASS" in played.stdout


def test_a_picture_of_its_run_has_its_curves_and_its_states(python, packages):
    picture = packages / "fan.svg"
    played = python("canopen_twins", "play", "fan_blocked.twin.yaml", "--plot", picture)
    assert played.returncode == 0, played.stderr
    drawn = picture.read_text("utf-8")
    assert all(word in drawn for word in ("Speed", "rpm", "free", "stuck"))


def test_its_record_has_the_version_of_its_package_and_can_be_replayed(python, packages):
    install(packages, project("broken", {"a_pump": "no_such_package:Pump"}))
    folder = packages / "record"
    played = python("canopen_twins", "play", "fan_blocked.twin.yaml", "--record", folder)
    assert played.returncode == 0, played.stderr
    versions = json.loads((folder / "run.json").read_text())["versions"]
    assert versions["canopen-fan"] == "1.0.0"
    assert "broken" not in versions
    assert python("canopen_twins", "replay", folder).returncode == 0


def test_its_own_tests_use_a_fixture_of_its_name(python):
    tested = python("pytest", "-q", "-p", "no:cacheprovider")
    assert "5 passed" in tested.stdout, tested.stdout


def test_it_holds_what_every_device_has_to(python):
    sweep = ROOT / "tests" / "test_every_device.py"
    tested = python("pytest", "-q", "-p", "no:cacheprovider", "-k", "fan", sweep, folder=ROOT)
    assert tested.returncode == 0, tested.stdout
    assert " passed" in tested.stdout


def test_a_name_that_is_taken_is_refused_with_both_owners(python, packages):
    install(packages, project("my-supplies", {"topcon": "canopen_fan:Fan"}))
    refused = python("canopen_twins", "objects", "topcon")
    assert refused.returncode == 2
    assert refused.stderr == (
        "canopen-twin: device 'topcon' comes from canopen-twins and from my-supplies: remove one\n"
    )


@pytest.mark.parametrize(
    ("what", "told"),
    [
        ("no_such_package:Pump", "No module named 'no_such_package'"),
        ("canopen_fan:Pump", "module 'canopen_fan' has no attribute 'Pump'"),
        ("canopen_fan:BLOCKED", "canopen_fan:BLOCKED is no Device"),
    ],
)
def test_one_that_is_broken_is_told_and_hides_no_other(python, packages, what, told):
    install(packages, project("my-pumps", {"pump": what}))
    listed = python("canopen_twins", "list")
    assert listed.returncode == 0
    assert "\nfan " in listed.stdout
    assert listed.stderr == f"device 'pump' of my-pumps: {told}\n"
    asked = python("canopen_twins", "objects", "pump")
    assert (asked.returncode, asked.stderr) == (2, f"canopen-twin: {listed.stderr}")


MISTAKEN = """
from canopen_fan import Fan
from canopen_twins import Abort, Device, Object, Rejected


class Untitled(Device):
    eds = Fan.eds


class Misread(Fan):
    title = "A fan that forgets to round"

    @property
    def objects(self):
        return {(0x2001, 0): Object(read=lambda: 12.5)}


class Refusing(Fan):
    title = "A fan that refuses the wrong way round"

    @property
    def objects(self):
        return {(0x2000, 0): Object(write=self.refuse)}

    def refuse(self, rpm):
        raise Rejected(Abort.TOO_HIGH, "too fast")
"""


@pytest.fixture
def mistaken(packages):
    """Devices whose author has made a mistake."""
    (packages / "mistaken.py").write_text(MISTAKEN)
    names = ("Untitled", "Misread", "Refusing")
    install(packages, project("my-fans", {name.lower(): f"mistaken:{name}" for name in names}))


def test_one_without_a_title_hides_no_other(python, mistaken):
    listed = python("canopen_twins", "list")
    assert listed.returncode == 0
    assert "\nfan " in listed.stdout
    (line,) = listed.stderr.splitlines()
    assert line.startswith("device 'untitled' of my-fans: Untitled has no title: write title = ")


@pytest.mark.parametrize(
    ("device", "step", "told"),
    [
        (
            "misread",
            "read: {Actual speed: 12}",
            "Misread: the object 0x2001:00 'Actual speed' reads 12.5, which does not fit"
            " UNSIGNED16, 12 would",
        ),
        ("refusing", "write: {Target speed: 12}", "Rejected(<Abort.TOO_HIGH: 101253169>, "),
    ],
)
def test_a_mistake_in_an_object_is_told_in_one_line_with_the_step(
    python, mistaken, tmp_path, device, step, told
):
    story = tmp_path / "story.yaml"
    story.write_text(f"version: 1\nnode: {{device: {device}}}\nsteps:\n  - {{at: 0, {step}}}\n")
    played = python("canopen_twins", "play", story)
    assert "Traceback" not in played.stderr
    assert told in played.stdout + played.stderr
    assert played.returncode != 0


def test_the_page_shows_the_files_as_they_are():
    assert set(SHOWN) == {
        str(path.relative_to(EXAMPLE))
        for path in EXAMPLE.rglob("*")
        if path.is_file() and path.suffix in {".py", ".toml", ".yaml"}
    }
    for name, text in SHOWN.items():
        assert (EXAMPLE / name).read_text("utf-8") == text, name
