"""check knows every kind of file that a user can write."""

import pytest

from canopen_twins.cli import main


@pytest.fixture
def checked(capsys):
    def checked(*names):
        code = main(["check", *map(str, names)])
        return (code, *capsys.readouterr())

    return checked


@pytest.mark.parametrize(
    "name",
    [
        "topcon_units.yaml",
        "charger_messages.yaml",
        "gateway_plain.yaml",
        "gateway_scaling.csv",
        "gateway_errors.yaml",
        "topcon.eds",
    ],
)
def test_every_file_beside_the_manuals_is_right(checked, name):
    assert checked(f"od/{name}")[0] == 0


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("version: 1\ntypes: []\n", ":2:8: empty; at least one unit type is wanted here"),
        ("version: 1\ngateway: {NoSuch: 1}\n", ":2:11: "),
        ("number,full_scale,unit,counts\n2000,none,rpm,64000\n", ""),
        ("format: charger_messages/1\nassumed: true\nerrors: 5\n", ":3:9: "),
        ("version: 1\ntiming: slow\nnodes: {one: {device: topcon}}\n", ":2:9: "),
        ("version: 1\nnodes: {one: {device: tobcon}}\n", "did you mean 'topcon'?"),
    ],
)
def test_what_is_wrong_is_told_by_whoever_reads_such_files(checked, tmp_path, text, told):
    path = tmp_path / ("ranges.csv" if text.startswith("number") else "file.yaml")
    path.write_text(text, "utf-8")
    code, out, err = checked(path)
    assert (code, out) == (2, "")
    assert told in err


def test_a_bench_file_with_its_timing_is_one(checked, tmp_path):
    path = tmp_path / "bench.yaml"
    path.write_text("version: 1\ntiming: worst\nnodes: {one: {device: charger}}\n", "utf-8")
    assert checked(path) == (0, f"{path}: ok\n", "")


def test_a_directory_is_told_what_to_name(checked, tmp_path):
    assert checked(tmp_path)[::2] == (
        2,
        f"{tmp_path} is a directory: name the files in it, such as {tmp_path}/*.yaml\n",
    )


def test_a_campaign_file_is_one(checked, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "contract.yaml").write_text("version: 1\nnode: {device: topcon}\nsteps: []\n")
    (tmp_path / "nightly.yaml").write_text("version: 1\ncontract: contract.yaml\nseeds: 3\n")
    assert checked("nightly.yaml") == (0, "nightly.yaml: ok\n", "")
    (tmp_path / "nightly.yaml").write_text("version: 1\ncontract: contract.yaml\nsed: 3\n")
    assert (
        checked("nightly.yaml")[2] == "nightly.yaml:3:1: unknown key 'sed': did you mean 'seeds'?\n"
    )
