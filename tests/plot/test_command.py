import sys

import pytest

from canopen_twins.cli import main

PLAY = ("play", "topcon_overvoltage.yaml")


@pytest.fixture
def said(capsys):
    """Run a command in this process: its exit code and what it said on stdout and stderr."""
    return lambda *arguments: (main([str(each) for each in arguments]), *capsys.readouterr())


@pytest.mark.parametrize(
    ("suffix", "begins"),
    [(".png", b"\x89PNG"), (".PNG", b"\x89PNG"), (".svg", b"<?xml"), (".html", b"<!DOCTYPE html>")],
)
def test_a_picture_is_drawn_beside_what_is_printed(said, tmp_path, suffix, begins):
    path = tmp_path / f"trip{suffix}"
    assert said(*PLAY, "--plot", path) == said(*PLAY)
    assert path.read_bytes().startswith(begins)


def test_a_run_that_fails_is_drawn_as_well(said, tmp_path):
    story, path = tmp_path / "story.yaml", tmp_path / "run.svg"
    steps = "[{at: 1, expect: {heartbeat: stopped, within: 1}}]"
    story.write_text(f"{{version: 1, node: {{device: topcon}}, steps: {steps}}}")
    assert said("play", story, "--plot", path)[0] == 1
    assert "FAIL line 1" in path.read_text("utf-8")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (
            [*PLAY, "gateway_supply.yaml", "--plot", "x.svg"],
            "--plot keeps one run: name one scenario",
        ),
        ([*PLAY, "--plot", "x.gif"], "x.gif is no picture: its name ends with .html, .png, .svg"),
        ([*PLAY, "--plot", "x"], "x is no picture: its name ends with .html, .png, .svg"),
        ([*PLAY, "--plot", "/nowhere/x.png"], "/nowhere/x.png: there is no directory for it"),
    ],
)
def test_wrong_input_is_told_before_anything_is_played(said, arguments, told):
    assert said(*arguments) == (2, "", f"canopen-twin: {told}\n")


def test_a_file_that_cannot_be_written_is_told(said, tmp_path):
    path = tmp_path / "folder.png"
    path.mkdir()
    told = f"canopen-twin: {path} is a directory, where a plain file is wanted\n"
    assert said(*PLAY, "--plot", path) == (2, "", told)


@pytest.fixture
def without_matplotlib(monkeypatch):
    """As on a machine that has none."""
    for name in list(sys.modules):
        if name.partition(".")[0] == "matplotlib":
            monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.delitem(sys.modules, "canopen_twins.record.plot.figure", raising=False)


def test_without_matplotlib_the_extra_is_named(said, without_matplotlib, tmp_path):
    path = tmp_path / "trip.png"
    told = "canopen-twin: a picture needs the extra: pip install 'canopen-twins[plot]'\n"
    assert said(*PLAY, "--plot", path) == (2, "", told)
    assert not path.exists()


def test_without_matplotlib_everything_else_works(said, without_matplotlib):
    assert said(*PLAY)[0] == 0
