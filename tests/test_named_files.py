"""Files that a user names: each is looked at before anything is played, opened or moved."""

import os
from pathlib import Path

import pytest

from canopen_twins.cli import main, parser
from canopen_twins.errors import UserError
from canopen_twins.files.whole import file_part, folder_part, live_file, write_whole

STORY = """\
version: 1
name: short
node: {device: topcon, node_id: 5}
steps:
  - {at: 0.1, expect: {value: {Nominal voltage: 400}}}
"""
WRITTEN = {"--junit": "{}", "--plot": "{}.svg", "--trace": "{}.log", "--record": "{}"}
BAD = {
    "circle": "links lead in a circle",
    "dangling": "there is no directory",
    "nowhere/file": "there is no directory",
    "s.yaml/file": "Not a directory",
    "a" * 300: "File name too long",
    "folder": "is a directory",
}

played = pytest.mark.parametrize("option", WRITTEN)


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder with a short story, links to nowhere, and a directory of every name."""
    monkeypatch.chdir(tmp_path)
    Path("s.yaml").write_text(STORY)
    for pattern in WRITTEN.values():
        circle, dangling, folder = (
            Path(pattern.format(n)) for n in ("circle", "dangling", "folder")
        )
        if not folder.exists():
            circle.symlink_to(circle)
            dangling.symlink_to("nowhere/file")
            (folder / "full").mkdir(parents=True)
    return tmp_path


@pytest.mark.parametrize(
    "words",
    [
        "play s.yaml --junit s.yaml",
        "play s.yaml --trace ./s.yaml",
        "play s.yaml --junit new --trace new",
        "run --scenario s.yaml --nvram link",
        "hunt s.yaml --html s.yaml",
        "campaign s.yaml --results s.yaml",
        "compare s.yaml topcon --html s.yaml",
    ],
)
def test_nothing_that_is_written_takes_the_place_of_what_is_read(here, capsys, words):
    Path("link").symlink_to("s.yaml")
    with pytest.raises(SystemExit, match="2"):
        main(words.split())
    assert Path("s.yaml").read_text() == STORY
    told = f"{words.split()[-1]} would take the place of another file that is named here"
    assert told.removeprefix("./") in capsys.readouterr().err


def test_two_reports_may_go_to_one_pipe():
    reports = ["--json", "/dev/null", "--junit", "/dev/null"]
    assert parser().parse_args(["campaign", "c.yaml", *reports]).json == Path("/dev/null")


@played
@pytest.mark.parametrize("name", BAD)
def test_what_can_be_no_file_is_told_in_one_line_before_anything_is_played(
    here, capsys, option, name
):
    assert main(["play", "s.yaml", option, WRITTEN[option].format(name)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    (line,) = err.splitlines()
    if option != "--record":  # which is a directory itself
        assert BAD[name] in line


@pytest.mark.parametrize("name", ["", ".", "folder", "circle", "a" * 300, "s.yaml/file"])
def test_a_memory_that_can_be_no_file_is_told_in_one_line(here, capsys, name):
    assert main(["run", "topcon", "-i", "virtual", "--nvram", name]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.mark.parametrize("record", ["/", "."])
def test_a_directory_that_is_full_is_no_record(here, capsys, record):
    assert main(["play", "s.yaml", "--record", record]) == 2
    assert "exists: a record has a directory of its own" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        "play topcon_overvoltage.yaml --junit x.xml",
        "play topcon_overvoltage.yaml --plot x.svg",
        "play topcon_overvoltage.yaml --trace x.log",
        "play topcon_overvoltage.yaml --record x",
        "run topcon -i virtual --nvram x",
        "check x.yaml",
        "eds x.eds",
    ],
)
def test_in_a_directory_that_is_gone_there_are_no_files(tmp_path, monkeypatch, capfd, words):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    Path.cwd().rmdir()
    assert main(words.split()) == 2
    out, err = capfd.readouterr()
    assert (out, len(err.splitlines())) == ("", 1), err


def test_a_record_may_go_where_a_link_leads(here):
    Path("place").mkdir()
    Path("link").symlink_to("place")
    assert main(["play", "s.yaml", "--record", "link"]) == 0
    assert Path("link").is_symlink()
    assert Path("place/run.json").is_file()


def test_what_is_called_like_the_value_of_a_setting_is_no_part_of_a_record(here):
    Path("bus").write_text("not of this run")  # TopCon's setting `control`
    assert main(["play", "s.yaml", "--record", "record"]) == 0
    Path("bus").unlink()
    assert main(["replay", "record"]) == 0


@pytest.mark.parametrize("part", [file_part, folder_part, live_file])
def test_what_one_run_writes_no_other_one_does(tmp_path, part):
    place = tmp_path / "place"
    with (
        part(place),
        pytest.raises(UserError, match="place belongs to another run"),
        part(place),
    ):
        pass
    assert place.exists()
    assert list(tmp_path.iterdir()) == [place]


def test_a_picture_that_cannot_be_written_leaves_the_old_one(tmp_path, monkeypatch):
    picture = tmp_path / "run.svg"
    picture.write_bytes(b"of yesterday")

    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        write_whole(picture, b"new")
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [
        ("run.svg", b"of yesterday")
    ]


@pytest.mark.parametrize("text", [r'name: "\ud800"', r'note: "half \udfff"'])
def test_half_a_character_is_told_with_its_place(here, capsys, text):
    story = STORY.replace("name: short", text) if text.startswith("name") else f"{STORY}{text}\n"
    Path("s.yaml").write_text(story)
    for command in ("check", "play"):
        assert main([command, "s.yaml"]) == 2
        said = "".join(capsys.readouterr())
        assert "half a character" in said
        assert "s.yaml:" in said


def test_half_a_character_in_a_record_is_damage(here, capsys):
    assert main(["play", "s.yaml", "--record", "record"]) == 0
    file = Path("record/run.json")
    file.write_text(file.read_text().replace('"topcon"', r'"topcon\ud800"', 1))
    capsys.readouterr()
    assert main(["replay", "record"]) == 2
    assert "run.json is damaged" in capsys.readouterr().err
