"""A hub for those who have started none: `--hub` without an address, with nobody there."""

import json
import socket
import sys

import pytest

from canopen_twins.bus.hub.client import HubBus, is_hub
from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.cli import bus, main
from canopen_twins.live.hub_process import hub_of_run, hub_process, hub_started

from .conftest import PATIENCE

STORY = """\
version: 1
node: {device: topcon, node_id: 5}
steps: [{at: 0, expect: {value: {0x1000: 0}}}]
"""


@pytest.fixture
def usual(monkeypatch):
    """Where the hub usually is, for this test alone, so that others do not meet it there."""
    with socket.create_server(("127.0.0.1", 0)) as found:
        address = HubAddress(*found.getsockname())
    monkeypatch.setattr(bus, "USUAL_HUB", address)
    return address


@pytest.fixture
def story(tmp_path):
    file = tmp_path / "story.yaml"
    file.write_text(STORY)
    return str(file)


def test_nobody_has_to_start_a_hub(usual, story, capfd):
    assert main(["run", "--scenario", story, "--hub"]) == 0
    out, err = capfd.readouterr()
    assert json.loads(out.splitlines()[0])["hub"] == str(usual)  # where everybody looks for it
    assert err == ""
    assert not is_hub(usual)  # it has ended with the run


def test_a_hub_of_a_run_that_comes_to_nothing_ends_with_it(usual, capfd):
    assert main(["run", "topcan", "--hub"]) == 2
    assert "did you mean 'topcon'?" in capfd.readouterr().err
    assert not is_hub(usual)


def test_a_hub_starts_while_the_twins_are_made(usual):
    with hub_started(usual) as hub:
        while not is_hub(usual):  # nobody has waited for it yet
            pass
        assert hub() == usual


def test_the_hub_that_is_there_is_joined(usual, story, capfd):
    with hub_process(usual), HubBus(usual, "vcan0") as neighbour:
        assert main(["run", "--scenario", story, "--hub"]) == 0
        assert neighbour.recv(PATIENCE).arbitration_id == 0x705
        assert is_hub(usual)
    assert json.loads(capfd.readouterr().out.splitlines()[0])["hub"] == str(usual)


def test_a_second_run_joins_the_hub_of_the_first(usual):
    with hub_of_run(usual) as first:
        assert first() == usual
        with hub_of_run(usual) as second:
            assert second() == usual


def test_where_another_program_is_the_hub_has_a_free_port(usual, capfd):
    with socket.socket() as other:
        other.bind(usual)
        with hub_of_run(usual) as hub:
            address = hub()
            assert address.port != usual.port
            assert is_hub(address)
    assert capfd.readouterr().err == ""


def test_a_run_with_a_command_has_a_hub_that_no_other_run_meets(usual, capfd):
    with hub_process(usual):
        run = ["run", "topcon", "-n", "5", "--hub", "--", sys.executable, "-c", "pass"]
        assert main(run) == 0
    assert json.loads(capfd.readouterr().out)["hub"] != str(usual)


def test_what_such_a_hub_has_to_tell_is_told(capfd):
    with hub_process() as address, socket.create_connection(address) as babbler:
        babbler.sendall(b"GET / HTTP/1.1")
        while babbler.recv(100):
            pass
    assert "refused: this is the protocol of socketcand" in capfd.readouterr().err
