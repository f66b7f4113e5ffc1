import json
import logging
import shlex
import socket
import struct
import subprocess
from contextlib import suppress
from itertools import product
from threading import Event, Thread

import can
import pytest

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.hub import connection
from canopen_twins.bus.hub.client import HubBus
from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.bus.hub.server import serve_hub
from canopen_twins.bus.python_can import frame_of
from canopen_twins.errors import UserError

from .conftest import PATIENCE, PROGRAM, Caller, hub_at

KINDS = ("ours", "stock")


def message(text):
    can_id, data, remote, extended = Frame.parse(text)
    return can.Message(
        arbitration_id=can_id, data=data, is_remote_frame=remote, is_extended_id=extended
    )


def hear(bus, patience=PATIENCE):
    came = bus.recv(patience)
    return came and str(
        Frame(came.arbitration_id, bytes(came.data), came.is_remote_frame, came.is_extended_id)
    )


@pytest.fixture
def join(request):
    """Joins a bus as one kind of client or the other."""
    return lambda kind, bus="vcan0": request.getfixturevalue(kind)(bus)


@pytest.mark.parametrize(("sender", "listener"), list(product(KINDS, KINDS)))
@pytest.mark.parametrize("text", ["605#4000100000000000", "080#", "18FF0102#01", "00000080#"])
def test_what_one_sends_the_other_hears(join, sender, listener, text):
    a, b = join(sender), join(listener)
    a.send(message(text))
    assert hear(b) == text


def test_a_remote_frame_gets_to_whoever_can_hear_one(ours, stock):
    twin, other, master = ours(), ours(), stock()
    master.send(message("185#R"))
    twin.send(message("7E5#R"))
    twin.send(message("185#01"))
    assert [hear(other) for _ in range(3)] == ["185#R", "7E5#R", "185#01"]
    assert hear(master) == "185#01"


def test_everybody_but_the_sender_hears_everything_in_one_order(stock):
    a, b, c = stock(), stock(), stock()
    for number in range(300):
        (a, b)[number % 2].send(message(f"123#{number:04X}"))
        assert hear(c) == f"123#{number:04X}"
    assert [hear(a) for _ in range(150)] == [f"123#{number:04X}" for number in range(1, 300, 2)]
    assert hear(a, 0) is None


def test_buses_have_nothing_to_do_with_each_other(ours):
    a, b, c = ours("left"), ours("right"), ours("right")
    a.send(message("001#"))
    b.send(message("002#"))
    assert hear(c) == "002#"
    assert hear(a, 0) is None


def test_a_bus_is_there_for_whoever_comes_next(ours):
    ours("vcan7").shutdown()
    a, b = ours("vcan7"), ours("vcan7")
    a.send(message("001#"))
    assert hear(b) == "001#"


def test_python_can_gets_on_a_bus_where_there_is_no_pause(ours, stock):
    noisy, stop = ours(), Event()

    def shout():
        while not stop.wait(0.001):  # as much as 1 Mbit/s has room for
            for _ in range(8):
                noisy.send(message("123#0102030405060708"))

    thread = Thread(target=shout)
    thread.start()
    try:
        for _ in range(5):
            assert hear(stock()) == "123#0102030405060708"
    finally:
        stop.set()
        thread.join()


REFUSED = {
    "GET / HTTP/1.1\r\n\r\n": "this is the protocol of socketcand",
    "\x80\xff": "this is the protocol of socketcand",
    "<" + 200 * "a": "more than 128 bytes and no end",
    "< open >": "the name of a bus is 1 to 16 letters, digits and _.-",
    "< open ../../etc/passwd >": "the name of a bus is 1 to 16 letters, digits and _.-",
    "< rawmode >": "unknown command, there is open",
    "< open vcan0 >< open vcan1 >": "unknown command, there is rawmode, own, echo",
    "< open vcan0 >< rawmode >< bcmmode >": "unknown command, there is send, sendrtr, echo",
    "< open vcan0 >< rawmode >< send 800 0 >": "there is no identifier 800",
    "< open vcan0 >< rawmode >< send 123 F 1 >": "no frame of classic CAN",
    "< open vcan0 >< rawmode >< send 123 2 11 >": "1 bytes of 2",
}


@pytest.mark.parametrize("said", REFUSED, ids=repr)
def test_whoever_talks_nonsense_is_told_and_sent_away(call, said, caplog):
    caller, other = call(), call().join()
    assert caller.hear() == "< hi >"
    caller.say(said)
    while (heard := caller.hear()) == "< ok >":
        pass
    assert heard == f"< error {REFUSED[said]} >"
    assert caller.hear() == ""
    assert [record.getMessage().partition(" refused: ")[2] for record in caplog.records] == [
        REFUSED[said]
    ]
    other.say("< echo >")
    assert other.hear() == "< echo >"


def test_what_was_said_before_nonsense_is_heard(call, ours):
    listener, confused = ours(), call().join()
    confused.say("< send 123 1 1 >< send 124 1 2 >< echo >< nonsense >< send 125 1 3 >")
    assert [str(frame_of(listener.recv(PATIENCE))) for _ in range(2)] == ["123#01", "124#02"]
    assert confused.hear() == "< echo >"
    assert confused.hear().startswith("< error unknown command")


def test_a_client_that_does_not_read_is_dropped_and_holds_nobody_up(
    call, ours, caplog, monkeypatch
):
    monkeypatch.setattr(connection, "MOST_WAITING", 1 << 16)
    dead = call(receive_buffer=4096).join()
    a, b = ours(), ours()
    for number in range(60_000):
        a.send(message(f"123#{number:016X}"))
        assert hear(b) == f"123#{number:016X}"
        if caplog.records:
            break
    name = HubAddress(*dead.socket.getsockname())
    assert [record.getMessage() for record in caplog.records] == [
        f"{name} does not read what is on vcan0: dropped"
    ]
    a.send(message("001#"))
    assert hear(b) == "001#"


def test_one_frame_is_not_behind_thousands_of_somebody_else(call):
    listener, flooder, other = (call().join() for _ in range(3))
    flooder.say("<send 181 1 00>" * 5000)
    other.say("<send 605 1 40>")
    heard = [listener.hear() for _ in range(5001)]
    place = next(place for place, text in enumerate(heard) if text.startswith("< frame 605"))
    assert place < 4500


def test_a_client_that_asks_and_does_not_read_is_dropped_too(call, caplog, monkeypatch):
    monkeypatch.setattr(connection, "MOST_WAITING", 1 << 16)
    dead = call(receive_buffer=4096).join()
    with suppress(ConnectionError):
        while not caplog.records:
            dead.say(1000 * "< echo >< send 001 0 >")
    assert caplog.records[0].getMessage().endswith("does not read what is on vcan0: dropped")


def test_a_client_that_does_not_read_why_is_forgotten(call, monkeypatch, caplog):
    monkeypatch.setattr(connection, "FAREWELL", 0.05)
    caplog.set_level(logging.INFO)
    dead, noisy = call(receive_buffer=4096).join(), call().join()

    def hub_is_through(*said):
        noisy.say("".join(said) + "< echo >")
        assert noisy.hear() == "< echo >"

    hub_is_through(20_000 * "< send 123 8 1 2 3 4 5 6 7 8 >")  # less than the hub keeps
    dead.say("nonsense")
    while f"{HubAddress(*dead.socket.getsockname())} has gone" not in caplog.text:
        hub_is_through()
    everything = b"".join(iter(lambda: dead.read(1 << 16), b""))
    assert b"error" not in everything


def test_a_client_that_is_gone_at_once_leaves_no_trace(call, ours):
    for _ in range(20):
        caller = call()
        caller.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        caller.socket.close()  # with a reset
    a, b = ours(), ours()
    a.send(message("001#"))
    assert hear(b) == "001#"


def test_there_is_an_end_to_the_number_of_clients(call, monkeypatch, caplog):
    monkeypatch.setattr(connection, "MOST_CLIENTS", 2)
    first, _, third = call(), call().join(), call()
    assert third.hear() == "< error there are 2 clients already >"
    assert third.hear() == ""
    first.socket.close()
    while True:  # until its place is free
        if (late := call()).hear() == "< hi >":
            break
    late.say("< open vcan0 >")
    assert late.hear() == "< ok >"


def test_a_hub_without_free_descriptors_says_so_once_and_waits(stack):
    command = f"ulimit -n 24; exec {shlex.join(PROGRAM)} hub --listen 127.0.0.1:0"
    with subprocess.Popen(
        ["sh", "-c", command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as hub:
        stack.callback(hub.terminate)
        address = HubAddress("127.0.0.1", json.loads(hub.stdout.readline())["port"])
        callers = [Caller(address) for _ in range(30)]
        assert hub.stderr.readline() == (
            "canopen-twin: nobody is let in at the moment: Too many open files\n"
        )
        last = callers.pop()
        for caller in callers:
            caller.socket.close()
        assert last.hear() == "< hi >"
        hub.terminate()
        assert hub.wait(PATIENCE) == 0
        assert hub.stderr.read() == ""
        last.socket.close()


def test_a_client_that_gets_on_no_bus_is_sent_away(call, monkeypatch):
    monkeypatch.setattr(connection, "HANDSHAKE", 0.05)
    idle, joined = call(), call().join()
    assert [idle.hear(), idle.hear()] == ["< hi >", "< error on no bus within 0 s >"]
    joined.say("< echo >")
    assert joined.hear() == "< echo >"


def test_an_address_in_use_is_wrong_input(hub):
    with pytest.raises(UserError, match=rf"^no hub at {hub}: Address already in use$"):
        serve_hub(hub, lambda: True, lambda address: None)


def test_a_hub_that_is_gone_is_an_error_of_the_bus(stack):
    with hub_at(HubAddress(port=0)) as address:
        bus = stack.enter_context(HubBus(address, "vcan0"))
    with pytest.raises(can.CanOperationError, match="the hub is gone"):
        bus.recv(PATIENCE)


def test_a_refusal_is_an_error_of_the_bus(hub, caplog):
    with pytest.raises(can.CanOperationError, match="the name of a bus"):
        HubBus(hub, "a bus")


def test_who_comes_and_goes_is_told_to_whoever_asks(hub, call, caplog):
    caplog.set_level(logging.INFO)
    caller = call().join("left")
    name = HubAddress(*caller.socket.getsockname())
    caller.socket.close()
    with HubBus(hub, "right"):
        pass
    assert f"{name} is on left" in caplog.text
