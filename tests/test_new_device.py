"""`canopen-twin new-device`: the package it writes passes its own tests."""

import importlib.util
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from test_third_party import install

from canopen_twins.cli import main

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "docs" / "examples"
KINDS = ROOT / "tests" / "eds" / "files"
WITHOUT_A_PAIR = """
[1000]
ParameterName=Device type
DataType=0x0007
AccessType=ro
[2000]
ParameterName=Setpoint
DataType=0x0008
AccessType=rw
"""


@pytest.fixture
def made(tmp_path, monkeypatch):
    """Writes a package as a user does, and runs a module in it as if it were installed."""
    monkeypatch.chdir(tmp_path)
    packages, folders = tmp_path / "packages", []
    packages.mkdir()

    def made(*arguments):
        assert main(["new-device", *arguments]) == 0
        (folder,) = set(tmp_path.glob("canopen-*")) - set(folders)
        folders.append(folder)
        install(packages, tomllib.loads((folder / "pyproject.toml").read_text("utf-8")))

        def run(*words):
            path = os.pathsep.join(map(str, (packages, *folders)))
            return subprocess.run(
                [sys.executable, "-m", *words],
                cwd=folder,
                env={**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"},
                capture_output=True,
                text=True,
                check=False,
            )

        return run

    return made


@pytest.mark.parametrize("kinds", [["plain"], ["io_block", "base", "odd"]], ids=" ".join)
def test_its_own_tests_and_its_story_pass(made, tmp_path, kinds):
    (tmp_path / "odd.eds").write_text(WITHOUT_A_PAIR)
    files = {
        "io_block": EXAMPLES / "io-block" / "io_block.eds",
        "base": KINDS / "00_base.eds",
        "odd": "odd.eds",
    }
    for kind in kinds:
        run = made(f"{kind}_pump", *(["--eds", str(files[kind])] if kind in files else []))
    words = [] if len(kinds) == 1 else sorted(map(str, tmp_path.glob("canopen-*")))
    tested = run("pytest", "-q", "-p", "no:cacheprovider", *words)
    passed = sum(2 if kind == "odd" else 4 for kind in kinds)  # which has no pair to follow
    assert f"\n{passed} passed" in tested.stdout, tested.stdout


def test_it_is_written_as_we_write(made):
    run = made("big_pump")  # that its types are right is seen by .ci/run
    if importlib.util.find_spec("ruff"):
        line = ("--isolated", "--line-length", "100")
        checked = run("ruff", "check", *line, "--select", "E,F,I,UP,B", ".")
        assert checked.returncode == 0, checked.stdout
        formatted = run("ruff", "format", *line, "--diff", ".")
        assert formatted.returncode == 0, formatted.stdout


def test_nothing_is_overwritten(made, capsys):
    made("pump")
    before = Path("canopen-pump/pyproject.toml").read_text()
    assert main(["new-device", "pump"]) == 2
    told = "canopen-twin: canopen-pump is there already, and nothing is overwritten\n"
    assert capsys.readouterr().err == told
    assert Path("canopen-pump/pyproject.toml").read_text() == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["Big-Pump"], "'Big-Pump' is no name of a device; they look like big_pump"),
        (["class"], "'class' is no name of a device"),
        (["topcon"], "there is a device 'topcon' already: take another name"),
        (["pump", "--eds", "no.eds"], "no.eds: No such file or directory"),
    ],
)
def test_what_cannot_be_made_is_told_and_leaves_nothing(
    tmp_path, monkeypatch, capsys, arguments, words
):
    monkeypatch.chdir(tmp_path)
    assert main(["new-device", *arguments]) == 2
    assert words in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
