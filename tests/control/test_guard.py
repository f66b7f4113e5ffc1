"""Who may use the control port, and who may not."""

import socket
from contextlib import ExitStack

import pytest

from canopen_twins.live.control import MOST_CONNECTIONS, guard

from .served import PATIENCE, served

TOKEN = "correct horse"


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1.evil.example", ""])
def test_a_name_that_is_not_of_this_machine_is_refused(port, host):
    answer = port.get("/nodes", Host=host)
    assert answer.status == 403
    assert "this port is called 127.0.0.1 or localhost" in answer.body["detail"]


@pytest.mark.parametrize("host", ["localhost", "localhost:8000", "127.0.0.1", "[::1]:1"])
def test_a_name_of_this_machine_is_taken(port, host):
    assert port.get("/nodes", Host=host).status == 200


@pytest.mark.parametrize("method", ["GET", "POST"])
def test_a_page_of_another_origin_is_refused(port, method):
    answer = port(method, "/nodes/topcon/faults/interlock_open", Origin="http://evil.example")
    assert answer.status == 403
    assert port.get("/nodes/topcon").body["faults"] == []


def test_its_own_page_is_not(port):
    origin = f"http://{port.address}"
    assert port("DELETE", "/nodes/topcon/faults", Origin=origin).status == 200


@pytest.mark.parametrize("kind", ["text/plain", "application/x-www-form-urlencoded", ""])
@pytest.mark.parametrize("method", ["POST", "PUT", "PATCH", "DELETE"])
def test_what_a_form_could_send_is_refused(port, method, kind):
    answer = port(method, "/nodes/topcon/faults/interlock_open", Content_Type=kind)
    assert answer == (415, {"detail": "say Content-Type: application/json"})
    assert port.get("/nodes/topcon").body["faults"] == []


def test_a_body_has_a_limit(port):
    answer = port("POST", "/nodes/topcon/faults/heartbeat_late", b" " * (1 << 18) + b"{}")
    assert answer == (413, {"detail": "the body is larger than 256 KiB"})


def test_with_a_token_every_request_has_to_bring_it():
    with served({"topcon": ("topcon", {})}, TOKEN) as port:
        for headers in ({}, {"Authorization": "Bearer wrong"}, {"Authorization": TOKEN}):
            for path in ("/nodes", "/openapi.json", "/nothing"):
                answer = port.get(path, **headers)
                assert answer.status == 401
                assert "--control-token" in answer.body["detail"]
        assert port.get("/nodes", Authorization=f"Bearer {TOKEN}").status == 200
        assert port.get("/nodes?token=correct%20horse").status == 200
        assert port.get("/nodes?token=correct+horse", Host="bench.example").status == 200


ORDER = b"POST /nodes/topcon/faults/heartbeat_late HTTP/1.1\r\nHost: localhost\r\n"
UNENDED = {
    "nothing": b"",
    "headers": b"GET /nodes HTTP/1.1\r\nHost: localhost\r\n",
    "body": ORDER + b"Content-Type: application/json\r\nContent-Length: 99\r\n\r\n{}",
    "answered": ORDER + b"Content-Length: 99\r\n\r\n{}",
    "second": b"GET /nodes HTTP/1.1\r\nHost: localhost\r\n\r\nGET /nodes",
}


@pytest.fixture
def hurried(monkeypatch, stack):
    """The port of a TopCon that waits for a short while only."""
    monkeypatch.setattr(guard, "PATIENCE", 0.3)
    return stack.enter_context(served({"topcon": ("topcon", {})}))


@pytest.fixture
def stack():
    with ExitStack() as stack:
        yield stack


def caller(port, stack, said):
    connection = stack.enter_context(socket.create_connection(port.address, PATIENCE))
    connection.sendall(said)
    return connection


def is_hung_up(connection):
    try:
        while connection.recv(1 << 16):
            pass
    except ConnectionResetError:
        pass
    return True  # or there was a timeout


@pytest.mark.parametrize("said", UNENDED)
def test_who_never_ends_a_request_keeps_no_connection_from_others(hurried, stack, said):
    callers = [caller(hurried, stack, UNENDED[said]) for _ in range(MOST_CONNECTIONS)]
    assert all(map(is_hung_up, callers))
    assert hurried.get("/nodes/topcon").body["faults"] == []  # half an order is none


def test_who_reads_no_answer_keeps_no_connection_from_others(hurried, stack):
    ask = b"GET /nodes/topcon/objects HTTP/1.1\r\nHost: localhost\r\n\r\n"
    deaf = socket.socket()
    deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 10)
    stack.enter_context(deaf).connect(hurried.address)
    deaf.settimeout(PATIENCE)
    with pytest.raises(ConnectionError):
        deaf.sendall(ask * 100_000)


def test_who_watches_may_stay(hurried, stack):
    with hurried.events("?kind=order") as events:
        assert is_hung_up(caller(hurried, stack, b""))
        hurried("POST", "/nodes/topcon/faults/heartbeat_late")
        assert next(events)["words"] == "inject heartbeat_late"
