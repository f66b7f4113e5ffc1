import os
import signal
import subprocess
import sys

import pytest

from tests.vcan.bus import CHANNEL, Lines, cansend

pytestmark = pytest.mark.vcan

BEAT = "2B17100032000000"  # a heartbeat every 50 ms


def link(state):
    subprocess.run(["ip", "link", "set", CHANNEL, state], check=True)


def test_two_twins_and_a_master_share_one_bus(run, candump, network):
    run("topcon", 5)
    run("topcon", 6)
    candump.until("706#00")
    nodes = [network.add_node(node_id) for node_id in (5, 6)]
    for node in nodes:
        node.sdo.download(0x2010, 0, bytes([node.id, 0]))
    assert [node.sdo.upload(0x2010, 0) for node in nodes] == [b"\x05\x00", b"\x06\x00"]
    network.nmt.state = "OPERATIONAL"
    cansend("185#R", "186#R")
    assert [frame[:5] for frame in candump.until("186#0")[-4:]] == [
        "185#R",
        "185#0",
        "186#R",
        "186#0",
    ]


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may take an interface down")
def test_a_twin_outlives_an_interface_that_goes_down_and_comes_back(run, candump):
    twin = run("topcon", 5)
    cansend(f"605#{BEAT}")
    candump.until("705#7F")
    link("down")
    told = Lines(twin.process.stderr)
    assert "the bus has failed" in told.next()
    link("up")
    assert "the bus works again" in told.next()


@pytest.mark.skipif(os.geteuid() != 0, reason="only root is granted so much memory for a socket")
def test_a_thousand_frames_wait_for_a_twin_that_stands_still(run, candump):
    twin = run("topcon", 5)
    cansend("605#2F00180201000000", "000#0105")
    candump.until("585#60")
    twin.process.send_signal(signal.SIGSTOP)
    subprocess.run(["cangen", CHANNEL, "-I", "080", "-L", "0", "-n", "1000", "-g", "0"], check=True)
    twin.process.send_signal(signal.SIGCONT)
    cansend("605#4000100000000000")
    frames = candump.until("585#4")
    assert sum(frame.startswith("185#") for frame in frames) == 1000


def test_sigterm_ends_a_twin_at_once(run):
    twin = run("topcon", 5)
    twin.process.send_signal(signal.SIGTERM)
    assert twin.process.wait(timeout=10.0) == 0


def test_a_twin_on_a_bus_that_is_not_there_is_told_in_one_line():
    command = [
        sys.executable,
        "-m",
        "canopen_twins",
        "run",
        "topcon",
        "-i",
        "socketcan",
        "-c",
        "vcan9",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "the bus cannot be opened" in done.stderr
