import os

import pytest

from canopen_twins.files.whole import write_whole


def test_a_file_is_replaced(tmp_path):
    path = tmp_path / "report"
    path.write_text("of yesterday")
    write_whole(path, "new")
    assert [(each.name, each.read_text()) for each in tmp_path.iterdir()] == [("report", "new")]


def test_what_cannot_be_replaced_stays_and_nothing_is_left_beside_it(tmp_path):
    (tmp_path / "report").mkdir()
    with pytest.raises(OSError, match="directory"):
        write_whole(tmp_path / "report", "new")
    assert [each.name for each in tmp_path.iterdir()] == ["report"]


def test_a_link_stays_one(tmp_path):
    (tmp_path / "link").symlink_to("report")
    write_whole(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "report").read_text() == "new"


def test_what_is_no_file_is_written_to_as_it_is(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    try:
        write_whole(path, "new")
        assert os.read(reader, 10) == b"new"
    finally:
        os.close(reader)
    assert path.is_fifo()
