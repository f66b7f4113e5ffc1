from pathlib import Path

import pytest
import yaml

from simulators.errors import UserError
from simulators.yaml_file import LARGEST_FILE, read_table

TABLES = sorted((Path(__file__).parents[1] / "od").glob("*.yaml"))


def rows(data):
    if not isinstance(data, list):
        raise ValueError("this is no list")
    return len(data)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "table.yaml"


def test_a_file_is_what_it_means(path):
    path.write_text("[1, 2, 3]")
    assert read_table(path, rows) == 3


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"{a: 1}", ": this is no list"),
        (b"- 1\n- [", ":2:4: expected the node content"),
        (b"\xff\xfe\xfd", ": 'utf"),
        (b"a: \x00", ": unacceptable character #x0000"),
        (b"#" * (LARGEST_FILE + 1), f": larger than {LARGEST_FILE} bytes"),
    ],
)
def test_what_is_wrong_is_told_in_one_line_with_its_place(path, content, told):
    path.write_bytes(content)
    with pytest.raises(UserError) as refusal:
        read_table(path, rows)
    assert str(refusal.value).startswith(f"{path}{told}")
    assert "\n" not in str(refusal.value)


def test_a_file_that_is_not_there_is_told():
    with pytest.raises(UserError, match=r"nowhere\.yaml: .*No such file"):
        read_table(Path("nowhere.yaml"), rows)


@pytest.mark.parametrize("table", TABLES, ids=lambda path: path.stem)
def test_the_tables_of_the_devices_mean_the_same_without_libyaml(table, monkeypatch):
    fast = read_table(table, repr)
    monkeypatch.delattr(yaml, "CSafeLoader")
    assert read_table(table, repr) == fast
