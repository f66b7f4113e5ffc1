"""Whatever happens to a twin, what has to hold of it holds; what does not is told as a scenario."""

import logging

import pytest
from conform.full import write_full

from benchmarks.fuzz.events import Send
from benchmarks.fuzz.world import World
from canopen_twins import devices
from canopen_twins.bus.frame import Frame
from canopen_twins.cli import main
from canopen_twins.diagnosis import frames
from canopen_twins.slave import sdo_server
from canopen_twins.slave.emcy import EmcyProducer
from canopen_twins.slave.error_control import HeartbeatProducer
from canopen_twins.slave.nmt import Nmt
from canopen_twins.slave.object import Entry
from canopen_twins.slave.sdo_server import SdoServer
from canopen_twins.slave.service import State
from canopen_twins.slave.tpdo import Tpdo
from life.machine import lives


@pytest.fixture(autouse=True)
def quiet():
    """What a twin logs of nonsense is not what these tests are about."""
    logging.disable(logging.WARNING)
    yield
    logging.disable(logging.NOTSET)


@pytest.fixture
def full(tmp_path):
    return str(write_full(tmp_path))


@pytest.mark.parametrize("device", devices.names())
def test_a_device_holds_whatever_happens(device):
    sent, failed = lives(device, count=10, steps=25)
    assert not failed, failed
    assert sent >= 25_000


def test_the_twin_of_a_file_holds_whatever_happens(full):
    sent, failed = lives(full, count=10, steps=25)
    assert not failed, failed
    assert sent >= 25_000


def test_a_reset_may_change_the_node_id_it_was_meant_for():
    world = World("charger", node_id=5)
    for frame in ("605#2F0220067F000000", "605#2310100173617665", "000#8205"):
        world.do(Send(Frame.parse(frame)))
    assert world.node.node_id == 127


def send_twice(producer, emcy, bits):
    """A bug: every emergency comes twice."""
    send(producer, emcy, bits)
    send(producer, emcy, bits)


def take_anything(entry, data):
    """A bug: limits are not looked at."""
    entry._cell[entry.variable.subindex] = data


def obey(service, frame):
    """A bug: what is meant for another node is obeyed."""
    on_command(service, Frame(frame.can_id, frame.data[:1] + b"\0"))


send, on_command = EmcyProducer._send, Nmt.on_command
BUGS = {
    "not silent": (SdoServer, "active_in", SdoServer.active_in | {State.STOPPED}),
    "not silent, in pre-operational": (
        Tpdo,
        "active_in",
        frozenset({State.PRE_OPERATIONAL, State.OPERATIONAL}),
    ),
    "not silent, to an abort": (sdo_server, "ABORTS", range(0)),
    "not silent, to what others are told": (Nmt, "on_command", obey),
    "untrue heartbeat": (HeartbeatProducer, "on_state", lambda *_: None),
    "EMCY twice": (EmcyProducer, "_send", send_twice),
    "limits": (Entry, "write", take_anything),
}


@pytest.mark.parametrize("bug", BUGS)
def test_a_bug_is_told_as_a_short_scenario_that_play_fails(full, bug, monkeypatch, tmp_path):
    monkeypatch.setattr(*BUGS[bug])
    _, failed = lives(full, count=20, steps=30)
    assert f"A random life: {bug.partition(',')[0]}" in failed
    assert failed.count("- at:") <= 8
    file = tmp_path / "found.yaml"
    file.write_text(failed)
    assert main(["play", str(file)]) == 1
    monkeypatch.undo()
    assert main(["play", str(file)]) == 0


def test_a_twin_that_raises_raises_in_the_scenario_that_is_told(monkeypatch, tmp_path):
    def fall_over(*_):
        raise ZeroDivisionError

    monkeypatch.setattr(SdoServer, "_refuse", fall_over)
    _, failed = lives("topcon", count=20, steps=30)
    assert failed.count("- at:") <= 2
    file = tmp_path / "found.yaml"
    file.write_text(failed)
    with pytest.raises(ZeroDivisionError):
        main(["play", str(file)])


def test_words_that_contradict_the_frames_are_found(full, monkeypatch):
    monkeypatch.setattr(frames, "_refused", lambda *_: "refused: just so")
    _, failed = lives(full, count=20, steps=30)
    assert "refused: just so, but it was" in failed
