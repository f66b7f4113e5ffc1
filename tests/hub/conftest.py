import json
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from queue import SimpleQueue
from threading import Event, Thread

import can
import pytest

from canopen_twins.bus.hub.client import HubBus
from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.bus.hub.server import serve_hub

PATIENCE = 30.0
EDS = str(Path(__file__).parents[2] / "od" / "topcon.eds")
PROGRAM = [sys.executable, "-m", "canopen_twins"]


class Caller:
    """A client that says what it is told to."""

    def __init__(self, address, receive_buffer=None):
        self.socket = socket.socket()
        if receive_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.socket.settimeout(PATIENCE)
        self.socket.connect(address)

    def say(self, text):
        self.socket.sendall(text.encode("latin-1"))

    def hear(self):
        """One element, or nothing if the hub has hung up."""
        heard = b""
        while not heard.endswith(b">"):
            if not (byte := self.read(1)):
                return heard.decode("ascii")
            heard += byte
        return heard.decode("ascii")

    def read(self, most):
        try:
            return self.socket.recv(most)
        except ConnectionError:
            return b""

    def join(self, bus="vcan0"):
        assert self.hear() == "< hi >"
        for command in (f"< open {bus} >", "< rawmode >"):
            self.say(command)
            assert self.hear() == "< ok >"
        return self


@contextmanager
def hub_at(address: HubAddress) -> Iterator[HubAddress]:
    """A hub in a thread; a bug comes out at the end."""
    ready: SimpleQueue = SimpleQueue()
    stop = Event()

    def work():
        try:
            serve_hub(address, stop.is_set, ready.put)
        except BaseException as bug:
            ready.put(bug)

    thread = Thread(target=work)
    thread.start()
    try:
        told = ready.get(timeout=PATIENCE)
        assert isinstance(told, HubAddress), told
        yield told
    finally:
        stop.set()
        thread.join(PATIENCE)
        assert not thread.is_alive()
    assert ready.empty(), ready.get()


@contextmanager
def started(*arguments):
    """A command in a process of its own, and its ready line; at the end it is told to stop."""
    with subprocess.Popen(
        [*PROGRAM, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            yield process, json.loads(process.stdout.readline())
        finally:
            process.terminate()
            process.out, process.err = process.communicate(timeout=PATIENCE)


@pytest.fixture(autouse=True)
def no_bug(caplog) -> Iterator[None]:
    """A bug in a callback is told by asyncio's log alone."""
    yield
    records = [*caplog.get_records("call"), *caplog.get_records("teardown")]
    assert [record.getMessage() for record in records if record.name == "asyncio"] == []


@pytest.fixture
def hub() -> Iterator[HubAddress]:
    """The address of a hub."""
    with hub_at(HubAddress(port=0)) as address:
        yield address


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def call(hub, stack) -> Callable[..., Caller]:
    """Connects to the hub."""

    def call(**options):
        caller = Caller(hub, **options)
        stack.callback(caller.socket.close)
        return caller

    return call


@pytest.fixture
def ours(hub, stack) -> Callable[..., HubBus]:
    """Joins as a twin does."""
    return lambda bus="vcan0": stack.enter_context(HubBus(hub, bus))


@pytest.fixture
def stock(hub, stack) -> Callable[..., can.BusABC]:
    """Joins with python-can's own interface."""

    def stock(bus="vcan0"):
        return stack.enter_context(
            can.Bus(interface="socketcand", channel=bus, host=hub.host, port=hub.port)
        )

    return stock
