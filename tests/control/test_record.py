"""What comes by the control port is part of a record: lived through again, it does the same."""

import os
import signal
import socket
import time
from threading import Thread

import can
import pytest

from canopen_twins import UserError, connect
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.python_can import message_of
from canopen_twins.cli import main
from canopen_twins.live.remote import RemotePort

from .served import PATIENCE
from .test_scenarios import ENDLESS, STORY


def work(twin, port, send):
    """Hands and a master at once."""
    send("605#2B17100014000000")  # heartbeat each 20 ms
    twin.inject("interlock_open")
    sum(range(10_000_000))  # nobody else has Python meanwhile: heartbeats are late, and left out
    with pytest.raises(UserError):
        twin.inject("interlock_open", x=1)
    send("605#4000200000000000")
    twin.set(load="resistor 7")
    twin.clear()
    twin.power_off()
    twin.power_on(load="resistor 3")
    send("605#2B17100014000000")
    port.call("POST", "/scenario", {"name": "trip.yaml", "text": STORY})
    while port.call("GET", "/scenario")["running"]:
        send("605#4000200000000000")
        time.sleep(0.01)
    port.call("POST", "/scenario", {"text": ENDLESS})
    port.call("DELETE", "/scenario")
    twin.inject("sdo_late", seconds=0.01)
    send("605#4000200000000000")


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    """The record of a run with a control port."""
    folder = tmp_path_factory.mktemp("record")
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"127.0.0.1:{server.getsockname()[1]}"
    bugs = []

    def hands(bus):
        try:
            assert bus.recv(PATIENCE) is not None  # the boot-up
            twin = connect(address)
            work(twin, RemotePort(address), lambda text: bus.send(message_of(Frame.parse(text))))
        except BaseException as bug:
            bugs.append(bug)
        finally:
            os.kill(os.getpid(), signal.SIGTERM)

    where = ("-i", "virtual", "-c", str(folder))
    with (
        pytest.MonkeyPatch.context() as patch,
        can.Bus(interface="virtual", channel=where[3]) as bus,
    ):
        patch.setenv("XDG_RUNTIME_DIR", str(folder))
        thread = Thread(target=hands, args=(bus,))
        thread.start()
        options = ("--record", str(folder / "kept"), "--control", address, *where)
        assert main(["run", "topcon", "-n", "5", "--set", "timing=ideal", *options]) == 0
        thread.join(PATIENCE)
    assert not bugs, bugs
    return folder / "kept"


def test_a_record_tells_what_was_ordered(record):
    events = (record / "events.jsonl").read_text()
    assert events.count('"kind": "order"') == 10
    assert '"arguments": ["interlock_open", {}]' in events
    assert '"kind": "stall"' in events


def test_it_is_lived_through_again_to_the_byte(record, capsys):
    assert main(["replay", str(record)]) == 0
    out, err = capsys.readouterr()
    assert out == (record / "trace.log").read_text()
    assert err.startswith("the same ")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"order": "inject"', '"order": "injekt"'),
        ('"arguments": ["interlock_open", {}]', '"arguments": 5'),
        ('"node": "topcon", "order"', '"node": "charger", "order"'),
        ('"unseen": ', '"unseen": true, "x": '),
    ],
)
def test_a_damaged_order_is_told(record, tmp_path, capsys, old, new):
    kept = tmp_path / "kept"
    kept.mkdir()
    for file in record.iterdir():
        (kept / file.name).write_bytes(file.read_bytes())
    events = kept / "events.jsonl"
    text = events.read_text()
    assert old in text
    events.write_text(text.replace(old, new, 1))
    assert main(["replay", str(kept)]) == 2
    assert "the record is damaged: " in capsys.readouterr().err
