import os

from simulators.whole_file import write_whole


def test_a_file_is_replaced(tmp_path):
    path = tmp_path / "report"
    path.write_text("of yesterday")
    write_whole(path, "new")
    assert [(each.name, each.read_text()) for each in tmp_path.iterdir()] == [("report", "new")]


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
