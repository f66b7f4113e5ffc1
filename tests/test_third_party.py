import importlib
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from canopen_twins import devices
from canopen_twins.cli import main
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


def project(name, brought):
    """One that brings devices."""
    return {"project": {"name": name, "version": "1", "entry-points": {GROUP: brought}}}


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


@pytest.fixture
def said(packages, monkeypatch, capsys):
    """Runs a command in this process as if the folder were among its packages."""
    monkeypatch.syspath_prepend(packages)
    monkeypatch.chdir(EXAMPLE)
    before = set(sys.modules)

    def said(*arguments):
        importlib.invalidate_caches()
        devices._installed.cache_clear()
        code = main([str(argument) for argument in arguments])
        return code, *capsys.readouterr()

    yield said
    devices._installed.cache_clear()
    for name in set(sys.modules) - before:
        if name.partition(".")[0] in {"canopen_fan", "mistaken"}:
            del sys.modules[name]


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
def test_every_command_knows_it(said, command, told):
    assert told in said(command, "fan")[1]


def test_its_story_is_played(said):
    code, out, err = said("play", "--raw", "fan_blocked.twin.yaml")
    assert code == 0, out + err
    assert "(0000000006.000000) can0 089#2171810000000000\n" in out
    assert "fan_blocked.twin.yaml: PASS" in out


def test_a_picture_of_its_run_has_its_curves_and_its_states(said, packages):
    picture = packages / "fan.svg"
    code, _, err = said("play", "fan_blocked.twin.yaml", "--plot", picture)
    assert code == 0, err
    drawn = picture.read_text("utf-8")
    assert all(word in drawn for word in ("Speed", "rpm", "free", "stuck"))


def test_its_record_has_the_version_of_its_package_and_can_be_replayed(said, packages):
    install(packages, project("broken", {"a_pump": "no_such_package:Pump"}))
    folder = packages / "record"
    code, _, err = said("play", "fan_blocked.twin.yaml", "--record", folder)
    assert code == 0, err
    versions = json.loads((folder / "run.json").read_text())["versions"]
    assert versions["canopen-fan"] == "1.0.0"
    assert "broken" not in versions
    assert said("replay", folder)[0] == 0


def test_its_own_tests_use_a_fixture_of_its_name(python):
    tested = python("pytest", "-q", "-p", "no:cacheprovider")
    assert "5 passed" in tested.stdout, tested.stdout


def test_it_holds_what_every_device_has_to(python):
    sweep = ROOT / "tests" / "test_every_device.py"
    tested = python("pytest", "-q", "-p", "no:cacheprovider", "-k", "fan", sweep, folder=ROOT)
    assert tested.returncode == 0, tested.stdout
    assert " passed" in tested.stdout


def test_a_name_that_is_taken_is_refused_with_both_owners(said, packages):
    install(packages, project("my-supplies", {"topcon": "canopen_fan:Fan"}))
    assert said("objects", "topcon") == (
        2,
        "",
        "canopen-twin: device 'topcon' comes from canopen-twins and from my-supplies: remove one\n",
    )


@pytest.mark.parametrize(
    ("what", "told"),
    [
        ("no_such_package:Pump", "No module named 'no_such_package'"),
        ("canopen_fan:Pump", "module 'canopen_fan' has no attribute 'Pump'"),
        ("canopen_fan:BLOCKED", "canopen_fan:BLOCKED is no Device"),
    ],
)
def test_one_that_is_broken_is_told_and_hides_no_other(said, packages, what, told):
    install(packages, project("my-pumps", {"pump": what}))
    code, out, err = said("list")
    assert code == 0
    assert "\nfan " in out
    assert err == f"device 'pump' of my-pumps: {told}\n"
    assert said("objects", "pump") == (2, "", f"canopen-twin: {err}")


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


def test_one_without_a_title_hides_no_other(said, mistaken):
    code, out, err = said("list")
    assert code == 0
    assert "\nfan " in out
    (line,) = err.splitlines()
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
    said, mistaken, tmp_path, device, step, told
):
    story = tmp_path / "story.yaml"
    story.write_text(f"version: 1\nnode: {{device: {device}}}\nsteps:\n  - {{at: 0, {step}}}\n")
    code, out, err = said("play", story)  # an exception that it is not made for would come out
    assert told in out + err
    assert code != 0


def test_the_page_shows_the_files_as_they_are():
    assert set(SHOWN) == {
        str(path.relative_to(EXAMPLE))
        for path in EXAMPLE.rglob("*")
        if path.is_file() and path.suffix in {".py", ".toml", ".yaml"}
    }
    for name, text in SHOWN.items():
        assert (EXAMPLE / name).read_text("utf-8") == text, name
