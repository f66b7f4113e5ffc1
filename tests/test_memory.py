import json
import logging
import os
from pathlib import Path

import pytest

from canopen_twins.errors import UserError
from canopen_twins.files.whole import held
from canopen_twins.slave.memory import LARGEST_FILE, Memory

LARGE = json.dumps({"parameters": {"2001:00": "0" * LARGEST_FILE}}).encode()


@pytest.fixture
def path(tmp_path):
    return tmp_path / "memory.json"


def test_what_nobody_stored_is_empty():
    assert Memory().load("parameters") == {}


def test_a_section_is_replaced_as_a_whole_and_the_others_stay():
    memory = Memory()
    memory.store("a", {"one": 1, "two": 2})
    memory.store("b", {"three": 3})
    memory.store("a", {"two": 22})
    assert (memory.load("a"), memory.load("b")) == ({"two": 22}, {"three": 3})


def test_nobody_can_change_the_memory_without_storing():
    memory, values = Memory(), {"one": 1}
    memory.store("a", values)
    values["one"] = 2
    memory.load("a")["one"] = 3
    assert memory.load("a") == {"one": 1}


def test_a_worn_memory_keeps_what_it_has_and_takes_nothing():
    memory = Memory()
    memory.store("a", {"one": 1})
    memory.worn = True
    with pytest.raises(OSError, match="worn"):
        memory.store("a", {"one": 2})
    assert memory.load("a") == {"one": 1}


def test_a_file_has_what_was_stored_when_store_returns(path):
    Memory(path).store("parameters", {"2001:00": "1234"})
    assert Memory(path).load("parameters") == {"2001:00": "1234"}


def test_the_same_content_makes_the_same_file(path):
    memory = Memory(path)
    memory.store("b", {"y": 1, "x": 2})
    memory.store("a", {})
    first = path.read_bytes()
    other = Memory(path.with_name("other.json"))
    other.store("a", {})
    other.store("b", {"x": 2, "y": 1})
    assert path.with_name("other.json").read_bytes() == first


def test_nothing_is_left_beside_the_file(path):
    Memory(path).store("a", {"one": 1})
    assert [entry.name for entry in path.parent.iterdir()] == [path.name]


@pytest.mark.parametrize(
    "content",
    [b"", b"{", b"[]", b'{"a": 1}', b"\xff\xfe", b"[" * 100_000, LARGE],
    ids=["empty", "broken", "list", "no sections", "no text", "deep", "large"],
)
def test_a_damaged_file_is_kept_beside_reported_and_replaced_by_defaults(path, content, caplog):
    path.write_bytes(content)
    with caplog.at_level(logging.ERROR):
        memory = Memory(path)
    assert memory.load("a") == {}
    assert path.with_name("memory.json.bad").read_bytes() == content
    assert "memory.json.bad" in caplog.text
    memory.store("a", {"one": 1})
    assert json.loads(path.read_text()) == {"a": {"one": 1}}


@pytest.mark.parametrize(
    ("name", "told"),
    [("", "is a directory, where a plain file"), ("missing/memory.json", "there is no directory")],
)
def test_a_path_that_can_hold_no_file_is_an_error_of_the_user(tmp_path, name, told):
    with pytest.raises(UserError, match=told):
        Memory(tmp_path / name)


@pytest.mark.parametrize("path", ["/dev/null", "/dev/full", "fifo", "circle", "dangling"])
def test_what_is_no_plain_file_is_refused_and_stays(tmp_path, monkeypatch, path):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("fifo")
    Path("circle").symlink_to("circle")
    Path("dangling").symlink_to("nowhere/memory.json")
    before = os.lstat(path)
    with pytest.raises(UserError):
        Memory(Path(path))
    after = os.lstat(path)
    assert (before.st_mode, before.st_ino) == (after.st_mode, after.st_ino)
    assert not Path(f"{path}.bad").exists()


def test_two_names_of_one_file_are_one_memory(tmp_path):
    file, link = tmp_path / "memory.json", tmp_path / "link.json"
    link.symlink_to(file)
    with held(link), pytest.raises(UserError, match="belongs to another run"), held(file):
        pass
    Memory(link).store("a", {"one": 1})
    assert Memory(file).load("a") == {"one": 1}
    assert link.is_symlink()


def test_a_memory_has_the_mode_of_its_file_or_that_of_any_new_one(tmp_path):
    new, kept = tmp_path / "new.json", tmp_path / "kept.json"
    kept.write_text("{}")
    kept.chmod(0o640)
    (tmp_path / "any").touch()
    for path in (new, kept):
        Memory(path).store("a", {})
    assert new.stat().st_mode == (tmp_path / "any").stat().st_mode
    assert kept.stat().st_mode & 0o777 == 0o640


def test_a_file_the_system_refuses_is_an_error_of_the_user_in_its_words(tmp_path):
    with pytest.raises(UserError, match="File name too long"):
        Memory(tmp_path / ("x" * 300))


def test_a_memory_that_cannot_be_written_is_as_before(path):
    memory = Memory(path)
    memory.store("a", {"one": 1})
    before = path.read_bytes()
    with pytest.raises(TypeError):
        memory.store("a", {"one": object()})
    assert (memory.load("a"), path.read_bytes()) == ({"one": 1}, before)
    assert [entry.name for entry in path.parent.iterdir()] == [path.name]


def test_a_folder_that_has_gone_is_an_error_of_the_system_and_changes_nothing(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    memory = Memory(folder / "memory.json")
    folder.rmdir()
    with pytest.raises(OSError, match="folder"):
        memory.store("a", {"one": 1})
    assert memory.load("a") == {}
