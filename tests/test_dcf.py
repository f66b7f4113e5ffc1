import subprocess
import sys

import canopen
import pytest

from canopen_twins import Bench, devices
from canopen_twins.cli import main

CONFIGURATION = """\
version: 1
gateway: {427: 5, 16404: 0x1F5}
governor: {CanOpenSendStatus: 1, 16404: 2300, 16461: 100}
"""


@pytest.fixture
def dcf(capsys, tmp_path):
    """The path of what `canopen-twin eds` prints."""

    def dcf(*arguments):
        assert main(["eds", *arguments]) == 0
        file = tmp_path / "device.dcf"
        file.write_text(capsys.readouterr().out, "ascii")
        return file

    return dcf


@pytest.fixture
def configuration(tmp_path):
    file = tmp_path / "configuration.yaml"
    file.write_text(CONFIGURATION)
    return f"config={file}"


def values(dictionary):
    """The parameters of a file by their addresses."""
    return {
        (variable.index, variable.subindex): variable.value
        for item in dictionary.values()
        for variable in (item.values() if hasattr(item, "subindices") else [item])
    }


@pytest.mark.parametrize("device", devices.names())
def test_it_has_the_entries_of_the_device_and_its_node_id(dcf, device):
    dictionary = canopen.import_od(str(dcf(device, "-n", "9")))
    bench = Bench(device, node_id=9)
    bench.run(10.0)
    known = bench.twin.node.slave.entries
    assert dictionary.node_id == 9
    assert {(index, sub) for index, sub in values(dictionary) if index >= 0x1000} == {
        (index, sub) for index, subs in known.items() for sub in subs
    }


@pytest.mark.parametrize("device", devices.names())
def test_other_tools_have_nothing_to_say(dcf, device):
    command = [sys.executable, "-m", "dcf.cli", "-n", "9", dcf(device, "-n", "9")]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")


@pytest.mark.parametrize("device", devices.names())
def test_it_is_the_same_each_time(dcf, device):
    first, second = (dcf(device, "-n", "9").read_text() for _ in range(2))
    assert first == second


@pytest.mark.spec("G-072", "G-074")
def test_a_configuration_of_the_gateway_is_what_a_master_needs(dcf, configuration):
    found = values(canopen.import_od(str(dcf("gateway", "--set", configuration))))
    assert found[0x1800, 1] == 0x185
    assert found[0x1804, 1] == 0x1F5
    assert found[0x1805, 1] is None  # as the EDS has it: not valid
    assert (found[0x1A04, 0], found[0x1A04, 1]) == (1, 0x20010510)
    assert (found[0x2000, 0], (0x2000, 7) in found) == (7, True)
    assert found[0x1017, 0] == 1000


def test_settings_change_limits_and_texts(dcf):
    settings = ("--set", "set_value_range=4400", "--set", "firmware=V4.10.00")
    dictionary = canopen.import_od(str(dcf("topcon", *settings)))
    assert dictionary[0x2010].max == 4400
    assert dictionary[0x100A].value == "V4.10.00"


def test_what_does_not_boot_has_none(capsys, tmp_path):
    file = tmp_path / "configuration.yaml"
    file.write_text("version: 1\ngateway: {428: 7, 427: 7}\n")
    assert main(["eds", "gateway", "--set", f"config={file}"]) == 2
    assert capsys.readouterr().err == "canopen-twin: with these settings it does not boot\n"


def test_a_configuration_has_an_option_of_its_own(capsys):
    assert main(["eds", "gateway", "--config", "gateway_plain.yaml"]) == 0
    short = capsys.readouterr().out
    assert main(["eds", "gateway", "--set", "config=gateway_plain.yaml"]) == 0
    assert capsys.readouterr().out == short
    assert main(["eds", "topcon", "--config", "gateway_plain.yaml"]) == 2
