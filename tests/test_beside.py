"""A project beside us that has folders of its own with the names of ours."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).parent / "project_beside"


@pytest.fixture
def python(tmp_path):
    """Runs a module in the folder of the project, where it stands by itself."""
    folder = shutil.copytree(PROJECT, tmp_path / "project")

    def python(*arguments):
        command = [sys.executable, "-B", "-m", *arguments]
        return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)

    return python


def test_its_tests_run_with_our_fixtures_and_its_scenarios_are_tests(python):
    tested = python("pytest", "-q", "-p", "no:cacheprovider")
    assert "6 passed" in tested.stdout, tested.stdout + tested.stderr


def test_our_command_works_there(python):
    played = python("canopen_twins", "play", "scenarios/boot.twin.yaml", "topcon_overvoltage.yaml")
    assert played.returncode == 0, played.stderr
    assert "scenarios/boot.twin.yaml: PASS (1 PASS)" in played.stdout
    assert "topcon_overvoltage.yaml: PASS (11 PASS)" in played.stdout
