"""The commands that touch a twin that runs, as one types them."""

import json
import os
import select
import signal
import subprocess
import sys
from http.server import BaseHTTPRequestHandler, HTTPServer
from threading import Thread

import pytest

from canopen_twins import UserError, connect
from canopen_twins.cli import main
from canopen_twins.cli.touch import event_line
from canopen_twins.live.running import Running, all_running, announced

from .served import PATIENCE

PROGRAM = (sys.executable, "-m", "canopen_twins")
RUN = ("run", "topcon", "-n", "5", "--set", "timing=ideal", "-i", "virtual", "-c", "touched")


@pytest.fixture(scope="module")
def runtime(tmp_path_factory):
    """A runtime directory for this module alone."""
    folder = tmp_path_factory.mktemp("runtime")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_RUNTIME_DIR", str(folder))
        yield folder


@pytest.fixture(scope="module")
def address(runtime):
    """The only twin of this user, in a process of its own."""
    with subprocess.Popen([*PROGRAM, *RUN, "--control"], stdout=subprocess.PIPE) as process:
        try:
            yield json.loads(process.stdout.readline())["control"]
        finally:
            process.terminate()


@pytest.fixture
def said(capsys):
    """Run a command in this process: its exit code and what it said on stdout and stderr."""

    def run(*arguments):
        code = main([str(argument) for argument in arguments])
        return code, *capsys.readouterr()

    return run


@pytest.mark.usefixtures("address")
def test_a_fault_is_injected_seen_and_cleared(said):
    code, out, err = said("inject", "heartbeat_late", "seconds=0.5")
    assert (code, err) == (0, "")
    assert json.loads(out)["node"] == "topcon"
    assert "faults: heartbeat_late(seconds=0.5)" in said("state")[1]
    told = said("faults")[1]
    assert told.startswith("Active:\n\nheartbeat_late(seconds=0.5)\n\nOf this device:\n")
    assert json.loads(said("faults", "--json")[1])["heartbeat_late"]["active"]
    assert said("clear")[0] == 0
    assert "faults: none" in said("state")[1]


@pytest.mark.usefixtures("address")
def test_the_load_the_values_and_the_supply(said):
    assert said("set", "load=resistor 7")[0] == 0
    assert said("get", "0x1018:01") == (0, f"{said('get', '0x1018:01')[1]}", "")
    assert "Device Type: " in said("get")[1]
    assert said("get", "Device Type", "--json")[1].startswith('{\n  "Device Type": ')
    assert said("power", "off")[0] == 0
    (told,) = json.loads(said("state", "--json")[1])
    assert told["powered"] is False
    assert "topcon: node 5, power off" in said("state", "--node", "topcon")[1]
    assert said("power", "on", "load=resistor 3")[0] == 0


def test_it_is_watched_until_one_has_seen_enough(said, address):
    command = [*PROGRAM, "watch", "--kind", "order", "--at", address]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            said("clear")
            while not select.select([process.stdout], [], [], 0.1)[0]:
                said("clear")  # it may not have been there yet
            assert process.stdout.readline().rstrip().endswith("  topcon      order: clear")
            process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE) == 130
        finally:
            process.kill()


def test_a_refusal_is_shown_with_its_reason():
    event = {
        "kind": "frame",
        "moment": 1_500_000,
        "node": "topcon",
        "words": "SDO abort",
        "frame": "585#80",
        "why": ["refused: too fast"],
    }
    assert event_line(event).splitlines() == [
        "    1.500000  topcon      585#80                 SDO abort",
        "                          why: refused: too fast",
    ]


def test_python_has_the_same_handle(address):
    twin = connect(address)
    assert twin.node_id == 5
    assert twin.powered
    twin.inject("heartbeat_late", seconds=0.5)
    assert twin.active_faults["heartbeat_late"]["seconds"] == 0.5
    twin.clear("heartbeat_late")
    assert twin.active_faults == {}
    twin.set(load="resistor 7")
    assert twin.settings["load"] == "resistor 7"
    twin.power_off()
    assert twin.state == "INITIALISING"
    twin.power_on()
    assert twin.report["state"] == "READY"
    assert list(twin.values("Device Type")) == ["Device Type"]
    assert connect(address.removeprefix("http://"), "5").node_id == 5


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["inject", "heartbeat_lat"], "did you mean 'heartbeat_late'?"),
        (["inject", "heartbeat_late", "seconds"], "seconds: write it as KEY=VALUE"),
        (["inject", "heartbeat_late", "seconds=x"], "wants a number, not 'x'"),
        (["clear", "heartbeat_lat"], "did you mean 'heartbeat_late'?"),
        (["set", "lode=1"], "did you mean 'load'?"),
        (["get", "Device Tipe"], "did you mean 'Device Type'?"),
        (["state", "--node", "topco"], "did you mean 'topcon'?"),
        (["power", "off", "load=1"], "taken over when the power comes"),
        (["watch", "--kind", "frames"], "did you mean 'frame'?"),
        (["faults", "topcon", "--node", "topcon"], "leave one of them out"),
        (["state", "--at", "127.0.0.1:1"], "no twin answers at http://127.0.0.1:1: "),
        (["state", "--at", "127.0.0.1"], "has no port: write HOST:PORT"),
    ],
)
@pytest.mark.usefixtures("address")
def test_what_is_wrong_is_told_in_one_line(said, arguments, told):
    code, out, err = said(*arguments)
    assert (code, out) == (2, "")
    assert told in err
    assert err.count("\n") == 1


def test_who_answers_with_something_else_is_no_twin():
    class Page(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.end_headers()
            self.wfile.write(b"<html>")

        def log_message(self, *told):
            pass

    with HTTPServer(("127.0.0.1", 0), Page) as server:
        thread = Thread(target=server.handle_request)
        thread.start()
        with pytest.raises(UserError, match="this is no JSON"):
            connect(f"127.0.0.1:{server.server_port}")
        thread.join()


@pytest.fixture
def alone(tmp_path, monkeypatch):
    """A runtime directory where nobody runs."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    return tmp_path


def test_without_a_twin_a_line_says_so(said, alone):
    code, _, err = said("state")
    assert code == 2
    assert err == (
        "canopen-twin: no twin of yours runs with --control: start one, or say --at HOST:PORT\n"
    )


def test_of_several_one_has_to_be_named(said, alone):
    with announced(Running("a", "http://127.0.0.1:1")), announced(Running("b", "http://[::1]:2")):
        assert [running.title for running in all_running()] == ["a", "b"]
        code, _, err = said("state")
    assert code == 2
    told = "several run, say which with --at: a at http://127.0.0.1:1, b at http://[::1]:2\n"
    assert err == f"canopen-twin: {told}"
    assert all_running() == []


def test_what_a_killed_run_has_left_is_removed(alone):
    folder = alone / "canopen-twins"
    folder.mkdir(mode=0o700)
    (folder / "1-1.json").write_text('{"title": "a", "address": "http://127.0.0.1:1"}')
    assert all_running() == []
    assert list(folder.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="there are no modes")
def test_a_directory_that_others_may_write_is_not_believed(said, alone):
    folder = alone / "canopen-twins"
    folder.mkdir()
    folder.chmod(0o777)
    code, _, err = said("state")
    assert code == 2
    assert "is not for you alone" in err


def test_without_a_runtime_directory_there_is_one_of_our_own(tmp_path, monkeypatch):
    monkeypatch.delenv("XDG_RUNTIME_DIR", raising=False)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with announced(Running("a", "http://127.0.0.1:1", "secret")):
        assert all_running() == [Running("a", "http://127.0.0.1:1", "secret")]
        (folder,) = tmp_path.iterdir()
        assert folder.stat().st_mode & 0o77 == 0
