"""The path of a file stands wherever the name of a device does."""

import logging
import shutil
import sys
from pathlib import Path

import canopen
import dcf.cli
import pytest
from until_ready import run_until_ready

from canopen_twins import Bench, UserError
from canopen_twins.cli import main

from .conftest import BASE, FILES, entry

STORY = """\
version: 1
node: {device: files/drive.eds, node_id: 5}
steps:
  - {at: 0.1, nmt: start}
  - {at: 0.2, write: {Set value: 8}}
  - {at: 0.3, read: {Set value: 8, 0x2001: 9}}
"""
BENCH = """\
version: 1
nodes:
  left: {device: files/drive.eds, node_id: 5}
  right: {device: files/drive.dcf}
"""
NAMED = """\
version: 1
node: {device: drive.eds, node_id: 5}
steps:
  - {at: 0.1, read: {Set value: 7}}
"""


@pytest.fixture
def said(capsysbinary):
    """Run a command in this process: its exit code and what it said on stdout and stderr."""

    def run(*arguments):
        code = main([str(argument) for argument in arguments])
        return code, *(text.decode() for text in capsysbinary.readouterr())

    return run


@pytest.fixture
def folder(tmp_path):
    """A scenario and a bench file, and beside them a folder with an EDS and a DCF file."""
    (tmp_path / "files").mkdir()
    shutil.copy(FILES / "00_base.eds", tmp_path / "files" / "drive.eds")
    shutil.copy(FILES / "37_dcf_with_node_id.dcf", tmp_path / "files" / "drive.dcf")
    (tmp_path / "story.yaml").write_text(STORY)
    (tmp_path / "bench.yaml").write_text(BENCH)
    return tmp_path


def ready(*arguments):
    """What `run` says when its twins have booted."""
    return run_until_ready(*arguments, "-i", "virtual", "-c", "files").ready


def test_it_is_run_with_the_node_id_that_is_said(folder):
    path = folder / "files" / "drive.eds"
    told = ready(path, "-n", "5")
    assert told == {"ready": str(path), "node_id": 5, "interface": "virtual", "channel": "files"}


def test_a_dcf_says_its_node_id_and_bit_rate(folder):
    told = ready(folder / "files" / "drive.dcf")
    assert (told["node_id"], told["bit_rate"]) == (16, 500000)


def test_a_bench_file_names_it_from_where_the_bench_file_is(folder):
    told = ready(folder / "bench.yaml")
    assert told["nodes"] == {"left": 5, "right": 16}
    assert told["bit_rate"] == 500000


def test_files_for_two_bit_rates_are_told(folder, caplog):
    dcf = (folder / "files" / "drive.dcf").read_text()
    (folder / "files" / "drive.eds").write_text(dcf.replace("Baudrate=500", "Baudrate=125"))
    told = ready(folder / "bench.yaml")
    assert "bit_rate" not in told
    assert "125000 bit/s and 500000 bit/s: one bus has one bit rate" in caplog.text


def test_a_scenario_names_it_from_where_the_scenario_is(folder, said):
    code, out, _ = said("play", folder / "story.yaml")
    assert code == 0, out
    assert "605#2B00200008000000" in out


@pytest.mark.parametrize(
    ("command", "shown"),
    [
        (("objects",), "0x2000:00  Set value"),
        (("settings",), "node_id 16 "),
        (("faults",), "sdo_abort"),
        (("list",), ""),
        (("eds",), "[DeviceComissioning]"),
        (("why", "0x2000=5"), "5 after boot-up: accepted"),
        (("why", "Set value"), "object   0x2000:00 Set value"),
    ],
)
def test_every_command_takes_it(folder, said, command, shown):
    name, *arguments = command
    code, out, _ = said(name, folder / "files" / "drive.dcf", *arguments)
    assert code == 0
    assert shown in out or shown in " ".join(out.split())


def test_eds_prints_it_byte_by_byte(capsysbinary):
    file = FILES / "07_windows_1252.eds"
    assert main(["eds", str(file)]) == 0
    assert capsysbinary.readouterr().out == file.read_bytes()


def test_an_unknown_device_and_a_file_that_is_not_there_are_told(said, tmp_path):
    code, _, told = said("objects", "servo")
    assert (code, told) == (
        2,
        "canopen-twin: unknown device 'servo': there is charger, gateway, topcon;"
        " a path to an EDS file is one, too\n",
    )
    missing = tmp_path / "drive.eds"
    assert said("objects", missing) == (
        2,
        "",
        f"canopen-twin: {missing}: No such file or directory\n",
    )


def test_a_bench_takes_a_path_or_a_class(folder):
    path = folder / "files" / "drive.eds"
    kind = type(Bench(path, node_id=5).device)
    benches = [Bench(path, node_id=5), Bench(str(path), node_id=5), Bench(kind, node_id=5)]
    assert [bench.sent for bench in benches] == [["705#00"]] * 3
    bench = Bench.of({"left": (path, 5), "right": (str(path), 6), "third": (kind, 7)})
    assert bench.sent == ["705#00", "706#00", "707#00"]
    assert bench["left"].sdo["Set value"].raw == 7


def test_the_fixtures_take_the_file_beside_the_test_and_a_class(pytester):
    pytester.path.joinpath("drive.eds").write_text(BASE)
    pytester.path.joinpath("drive.twin.yaml").write_text(NAMED)
    pytester.makepyfile("""
        from canopen_twins import Device, NodeSettings, Bench

        class Drive(Device):
            eds = str(__import__("pathlib").Path(__file__).with_name("drive.eds"))
            title = "A drive"

        def test_bench(canopen_bench):
            for device in ("drive.eds", Drive):
                assert canopen_bench(device, node_id=5).sent == ["705#00"]
                assert canopen_bench.of({"a": (device, 6)}).sent == ["706#00"]

        def test_device(canopen_device):
            for device in ("drive.eds", Drive):
                assert canopen_device(device, node_id=5).values("Set value") == {"Set value": 7}
    """)
    run = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    run.assert_outcomes(passed=3)


def test_a_record_needs_the_file_no_more(folder, said):
    assert said("play", folder / "story.yaml", "--record", folder / "record")[0] == 0
    shutil.rmtree(folder / "files")
    code, _, told = said("replay", folder / "record")
    assert (code, told) == (0, "the same 8 frames and 7 events\n")
    assert said("diff", folder / "record", folder / "record")[0] == 0


def test_a_record_of_a_real_run_needs_it_no_more(folder, said):
    ready(folder / "bench.yaml", "--record", folder / "record")
    shutil.rmtree(folder / "files")
    code, out, _ = said("replay", folder / "record")
    assert code == 0
    assert [line.split()[-1] for line in out.splitlines()] == ["705#00", "710#00"]


def test_a_record_keeps_the_file_that_a_domain_serves(folder, said):
    domain = entry(0x2200, 0xF, "", "UploadFile=C:\\work\\firmware.bin\n")
    (folder / "files" / "drive.eds").write_text(BASE + domain)
    (folder / "files" / "firmware.bin").write_bytes(b"\x01\x02")
    assert said("play", folder / "story.yaml", "--record", folder / "record")[0] == 0
    kept = sorted(path.name for path in (folder / "record" / "devices" / "1").iterdir())
    assert kept == ["drive.eds", "firmware.bin"]


def test_a_picture_of_its_run_can_be_drawn(folder, said):
    picture = folder / "run.svg"
    assert said("play", folder / "story.yaml", "--plot", picture)[0] == 0
    assert picture.read_bytes().startswith(b"<?xml")


def test_a_name_of_two_objects_is_said_to_be_one_by_scenarios_and_why(folder, said):
    path = folder / "files" / "drive.eds"
    shutil.copy(FILES / "52_same_name_twice.eds", path)
    told = "'Set value' is the name of 0x2000:00 and 0x2002:00: say which by its address\n"
    assert said("why", path, "Set value") == (2, "", f"canopen-twin: {told}")
    code, _, wrong = said("check", folder / "story.yaml")
    assert code == 2
    assert f"{folder}/story.yaml:5:23: {told}" in wrong


def test_what_is_unusual_is_warned_of_once(caplog):
    path = FILES / "48_data_type_missing.eds"
    copy = Path(shutil.copy(path, path.parent.parent / "once.eds"))
    try:
        with caplog.at_level(logging.WARNING):
            for _ in range(2):
                Bench(copy)
    finally:
        copy.unlink()
    assert caplog.messages == ["once.eds:173: [2002] has no DataType: left out"]


def test_check_says_what_is_unusual_and_what_is_made_of_it(said):
    path = FILES / "33_section_twice.eds"
    assert said("check", path) == (
        0,
        f"{path}:173: [2001] is there in line 166 already: what stands here holds\n"
        f"{path}: ok, with 1 remark\n",
        "",
    )


def test_check_takes_files_of_every_kind(folder, said):
    files = [folder / "story.yaml", folder / "bench.yaml", folder / "files" / "drive.dcf"]
    code, out, _ = said("check", *files, "topcon_i2t.yaml")
    assert (code, out) == (0, "".join(f"{file}: ok\n" for file in [*files, "topcon_i2t.yaml"]))


def test_check_refuses_what_no_twin_can_be_made_of(folder, said):
    empty = folder / "empty.eds"
    empty.write_text("hello\n")
    bench = folder / "bench.yaml"
    bench.write_text(BENCH.replace("drive.dcf", "drve.dcf"))
    code, out, wrong = said("check", empty, bench)
    assert (code, out) == (2, "")
    assert wrong == (
        f"{empty} is no EDS file: it has no object, such as [1000]\n"
        f"{bench}:4:19: {folder}/files/drve.dcf: No such file or directory\n"
    )


def test_what_has_no_steps_is_checked_as_a_bench_file(folder, said):
    (folder / "bench.yaml").write_text(BENCH.replace("node_id: 5", "node_id: 128"))
    code, _, wrong = said("check", folder / "bench.yaml")
    assert (code, wrong) == (2, f"{folder}/bench.yaml:3:44: node id 128 is not in 1..127\n")


def test_a_device_of_a_name_with_a_suffix_is_a_file():
    with pytest.raises(UserError, match=r"nothing\.EDS: No such file"):
        Bench("nothing.EDS")


NO_IDENTITY = {"35_identity_as_plain_variable.eds"}  # which dcfchk cannot do without
OTHERS = {  # their PDOs are told elsewhere
    "28_pdo_without_mapping.eds",
    "29_mapping_of_nothing.eds",
    "63_fixed_mapping_with_unused_zeros.eds",
}


@pytest.mark.parametrize("name", sorted({path.name for path in FILES.iterdir()} - OTHERS))
def test_the_dcf_of_a_twin_has_nothing_unusual_any_more(said, tmp_path, monkeypatch, name):
    code, text, _ = said("eds", FILES / name, "-n", "7")
    assert code == 0
    file = tmp_path / "twin.dcf"
    file.write_text(text, "utf-8")
    assert said("check", file)[1] == f"{file}: ok\n"
    assert canopen.import_od(str(file)).node_id == 7
    if name not in NO_IDENTITY:
        monkeypatch.setattr(sys, "argv", ["dcfchk", "-n", "7", str(file)])
        dcf.cli.main()  # or SystemExit, or a warning
        assert said("check", file)[2] == ""
    mine, its = Bench(FILES / name, node_id=7), Bench(file)
    assert mine.values() == its.values()
