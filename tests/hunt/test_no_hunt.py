"""What keeps a hunt from beginning is told in one line."""

import sys

import pytest

from canopen_twins.cli import main

from .masters import BRITTLE, CAREFUL, CONTRACT


@pytest.mark.parametrize(
    ("master", "contract", "said"),
    [
        ("def main(network): pass\n", CONTRACT, "this master does not keep the contract"),
        ("def main(network): 1 / 0\n", CONTRACT, "ZeroDivisionError: division by zero"),
        ("def other(): pass\n", CONTRACT, "unknown function 'main'"),
        (CAREFUL, CONTRACT.replace("sdo_silence", "sdo_silent"), "did you mean 'sdo_silence'?"),
        (CAREFUL, CONTRACT.replace("duration", "durations"), "unknown key 'durations'"),
        (CAREFUL, CONTRACT.partition("duration")[0] + "steps: []\n", "give it a 'duration'"),
        (CAREFUL, "version: 1\nsteps: [", "contract.yaml:2:"),
        (
            CAREFUL.replace(
                "time.sleep(0.5)", "time.sleep(__import__('time').time_ns() % 97 / 100)"
            ),
            CONTRACT,
            "two runs without any fault are not the same",
        ),
    ],
)
def test_no_hunt_begins_with_a_contract_that_is_not_kept(hunted, master, contract, said):
    code, told = hunted(master, "--runs", "9", contract=contract)
    assert (code, said in told) == (2, True), told


def test_who_is_tested_has_to_be_said(tmp_path, capsys):
    (tmp_path / "contract.yaml").write_text(CONTRACT)
    assert main(["hunt", str(tmp_path / "contract.yaml"), "--runs", "9"]) == 2
    assert "who is tested? Say --master MODULE:FUNCTION" in capsys.readouterr().err


def test_one_master_is_tested(hunted):
    code, told = hunted(CAREFUL, "--", "true")
    assert (code, "one master is tested" in told) == (2, True)


def test_a_damaged_find_is_told_with_its_place(hunted, tmp_path):
    (tmp_path / "finds").mkdir()
    (tmp_path / "finds" / "hunt-1.twin.yaml").write_text("version: 1\nstep: []\n")
    code, said = hunted(CAREFUL, "--runs", "2", "--finds", "finds")
    assert (code, said.count("hunt-1.twin.yaml")) == (2, 1), said
    assert said.startswith("canopen-twin: finds/hunt-1.twin.yaml:2:1: unknown key 'step'")


def test_finds_have_to_find_their_master_from_where_they_lie(here, tmp_path, monkeypatch, capsys):
    for folder in ("house", "elsewhere"):
        (tmp_path / folder).mkdir()
    (tmp_path / "house" / "my_master.py").write_text(BRITTLE)
    (tmp_path / "house" / "contract.yaml").write_text(CONTRACT)
    monkeypatch.chdir(tmp_path / "elsewhere")
    hunt = ["hunt", "../house/contract.yaml", "--master", "my_master:main", "--runs", "2"]
    assert main(hunt) == 2
    said = capsys.readouterr().err
    assert said == (
        "canopen-twin: finds in . would not find their master 'my_master:main': there is no module"
        " 'my_master' here or beside the file: have a folder for them beside the contract"
        " (--finds)\n"
    )
    assert main([*hunt, "--finds", "../house"]) == 1
    assert (tmp_path / "house" / "hunt-1.twin.yaml").is_file()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--finds", "nowhere"], "there is no directory nowhere"),
        pytest.param(
            *(["--finds", "/proc"], "finds cannot be written to /proc: "),
            marks=pytest.mark.skipif(sys.platform != "linux", reason="has no such folder"),
        ),
        (["--html", "nowhere/page.html"], "there is no directory for it"),
        (["--runs", "0"], "at least one run"),
    ],
)
def test_what_cannot_be_is_told_before_anything_is_played(hunted, arguments, said):
    code, told = hunted(CAREFUL, *arguments)
    assert (code, said in told) == (2, True), told


def test_without_hypothesis_it_says_at_once_what_is_missing(hunted, monkeypatch):
    monkeypatch.setitem(sys.modules, "hypothesis", None)
    code, said = hunted(CAREFUL, "--runs", "1")
    assert code == 2
    assert said == "canopen-twin: a hunt needs the extra: pip install 'canopen-twins[hunt]'\n"
