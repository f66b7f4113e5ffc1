"""What tests of hunts share."""

from contextlib import nullcontext
from importlib import import_module

import pytest

from canopen_twins.cli import main
from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.run import run_to_compare
from canopen_twins.hunt.workers import in_turn

from .masters import CONTRACT


def play_here(patch):
    """Let runs be played in this process, as those of one job are on Windows.

    Another takes a third of a second until it can play anything.
    """

    def workers(jobs, lost):
        assert jobs == 1
        return nullcontext(in_turn)

    # modules are imported, not named: the test of a page leaves some that are imported anew
    for user in ("cli.hunt", "cli.campaign", "hunt.workers"):
        patch.setattr(import_module(f"canopen_twins.{user}"), "workers", workers)


def look_again_here(patch):
    """Let finds be seen again in this process: each begins two others for that."""
    patch.setattr(
        import_module("canopen_twins.hunt.find"),
        "in_another_process",
        lambda path, master: run_to_compare(Contract(path, master), Plan()),
    )


@pytest.fixture
def here(monkeypatch):
    """Nothing is played in other processes: for tests that are not about these."""
    play_here(monkeypatch)
    look_again_here(monkeypatch)


@pytest.fixture
def hunted_elsewhere(tmp_path, monkeypatch, capsys):
    """Hunt a master in other processes; exit code and what is said."""
    monkeypatch.chdir(tmp_path)

    def hunted(master, *arguments, contract=CONTRACT):
        (tmp_path / "my_master.py").write_text(master)
        (tmp_path / "contract.yaml").write_text(contract)
        named = ["--master", "my_master:main", *arguments]
        code = main(["hunt", "contract.yaml", *named])
        said = capsys.readouterr()
        return code, said.out + said.err

    return hunted


@pytest.fixture
def hunted(here, hunted_elsewhere):
    """The same in this one."""
    return hunted_elsewhere
