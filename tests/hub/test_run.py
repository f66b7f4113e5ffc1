import json
import subprocess
from threading import Event, Thread

import can
import canopen
import pytest

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.python_can import frame_of
from canopen_twins.cli import main

from .conftest import EDS, PATIENCE, PROGRAM, started

pytestmark = pytest.mark.usefixtures("quick_to_disconnect")

TWO = """\
version: 1
nodes:
  left: {device: topcon, node_id: 5, settings: {serial: 7}}
  right: {device: topcon, node_id: 6, settings: {serial: 8}}
"""


@pytest.fixture
def bench(tmp_path):
    file = tmp_path / "bench.yaml"
    file.write_text(TWO)
    return str(file)


def test_a_bench_file_puts_all_of_its_twins_on_one_bus(bench, hub, stock):
    with (
        started("run", bench, "--hub", str(hub)) as (_, ready),
        canopen.Network(stock()) as network,
    ):
        assert ready == {
            "ready": bench,
            "nodes": {"left": 5, "right": 6},
            "hub": str(hub),
            "channel": "vcan0",
        }
        network.connect()
        for node_id, serial in ((5, 7), (6, 8)):
            node = network.add_node(node_id, EDS)
            assert node.sdo["Identity Object"]["Serial number"].raw == serial


OF_ONE = ["-n 5", "--set load=open", "--scenario topcon_overvoltage.yaml", "--nvram memory"]


@pytest.mark.parametrize("option", OF_ONE)
def test_options_of_one_device_do_not_go_with_a_bench_file(bench, option, capsys, monkeypatch):
    monkeypatch.chdir(bench.rpartition("/")[0])
    assert main(["run", bench, *option.split(), "--hub"]) == 2
    assert f"{bench} says all about its nodes: leave --" in capsys.readouterr().err


def test_a_mistake_in_a_bench_file_is_told_with_its_place(tmp_path, capsys):
    file = tmp_path / "bench.yaml"
    file.write_text(TWO.replace("6", "5"))
    assert main(["run", str(file), "--hub"]) == 2
    assert (
        capsys.readouterr().err
        == f"canopen-twin: {file}:4:3: two nodes with node id 5 on one bus\n"
    )


def test_a_second_node_with_an_id_is_refused_by_the_hub_at_joining(hub, capsys):
    with started("run", "topcon", "-n", "5", "--hub", str(hub)):
        assert main(["run", "charger", "-n", "5", "--hub", str(hub)]) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert "the hub says: error node 5 is on vcan0 already, of 127.0.0.1:" in err
        with started("run", "topcon", "-n", "5", "--hub", str(hub), "-c", "another") as (_, ready):
            assert ready["channel"] == "another"
        with started("run", "topcon", "-n", "6", "--hub", str(hub)) as (_, ready):
            assert ready["node_id"] == 6
    with started("run", "topcon", "-n", "5", "--hub", str(hub)) as (_, ready):  # it is free again
        assert ready["node_id"] == 5


def say(bus, text):
    frame = Frame.parse(text)
    bus.send(can.Message(arbitration_id=frame.can_id, data=frame.data, is_extended_id=False))


def test_a_node_id_that_is_alive_on_the_bus_is_not_taken(hub, ours):
    stranger, end = ours(), Event()

    def beat():
        while not end.wait(0.02):
            say(stranger, "705#7F")

    beating = Thread(target=beat)
    beating.start()
    second = [*PROGRAM, "run", "topcon", "-n", "5", "--hub", str(hub)]
    done = subprocess.run(second, capture_output=True, text=True, check=False)
    end.set()
    beating.join()
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "canopen-twin: node 5 is on the bus already: it has sent 705#7F\n"


DOUBLE = "topcon: another node on the bus has node id 5, too: it has sent 085#0010010000000000"


@pytest.mark.parametrize(("option", "code"), [((), 2), (("--no-exclusive",), 0)])
def test_a_twin_that_hears_its_own_identifiers_says_so(hub, ours, option, code):
    stranger = ours()
    with started("run", "topcon", "-n", "5", "--hub", str(hub), *option) as (run, _):
        say(stranger, "605#4000100000000000")
        while str(frame_of(stranger.recv(PATIENCE))) != "585#4300100000000000":
            pass
        say(stranger, "085#0010010000000000")
        if code:
            run.wait(PATIENCE)
        else:
            say(stranger, "605#4000100000000000")
            assert stranger.recv(PATIENCE).arbitration_id == 0x585
    assert run.returncode == code
    assert run.err.startswith(f"canopen-twin: {DOUBLE}\n")


def test_a_verdict_says_that_another_node_has_the_id(hub, ours, tmp_path):
    (tmp_path / "story.yaml").write_text(
        "version: 1\nnode: {device: topcon, node_id: 5}\n"
        "steps: [{at: 0, expect: {emcy: none, within: 60}}]\n"
    )
    story = ("--scenario", str(tmp_path / "story.yaml"))
    with started("run", *story, "--hub", str(hub)) as (run, _):
        say(ours(), "705#05")
        run.wait(PATIENCE)
    assert run.returncode == 2
    assert "story.yaml: ERROR (2 ERROR)" in run.out
    assert "node id of topcon: another node on the bus has node id 5, too: it has" in run.out


REAL = {
    "-i socketcan -c can0": "socketcan can0",
    "-i slcan -c /dev/ttyACM0": "slcan /dev/ttyACM0",
    "-i socketcand -c vcan0 --bus-kwargs host=192.0.2.1 port=29536": "socketcand vcan0",
    "--hub 192.0.2.1": "192.0.2.1:29536 vcan0",
}
VIRTUAL = [
    "-i socketcan -c vcan7_nowhere",
    "-i socketcan -c vxcan7",
    "-i udp_multicast -c 239.74.163.2 --bus-kwargs port=x",
    "-i socketcand -c vcan0 --bus-kwargs host=localhost",
    "--hub :1",
]


@pytest.mark.parametrize("options", REAL)
def test_a_bus_that_may_be_real_is_asked_for(options, capsys):
    assert main(["run", "topcon", *options.split()]) == 2
    assert capsys.readouterr().err == (
        f"canopen-twin: there may be real devices on {REAL[options]}: "
        "say --real-bus if you mean it\n"
    )


@pytest.mark.parametrize("options", VIRTUAL)
def test_a_virtual_bus_is_just_opened(options, capsys):
    assert main(["run", "topcon", *options.split()]) == 2
    assert "the bus cannot be opened" in capsys.readouterr().err


def test_a_real_bus_that_was_asked_for_is_opened(capsys):
    assert main(["run", "topcon", "-i", "slcan", "-c", "/nowhere", "--real-bus"]) == 2
    assert "the bus cannot be opened" in capsys.readouterr().err


def test_the_configuration_of_python_can_counts_too(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("CAN_INTERFACE", "socketcan")
    monkeypatch.setenv("CAN_CHANNEL", "can3")
    assert main(["run", "topcon"]) == 2
    assert "there may be real devices on socketcan can3" in capsys.readouterr().err
    monkeypatch.setenv("CAN_INTERFACE", "virtual")
    with started("run", "topcon") as (_, ready):
        assert json.dumps(ready["interface"]) == '"virtual"'
