"""Twins on a `virtual` bus with a control port, in threads, and who speaks to it."""

import json
from contextlib import contextmanager
from http.client import HTTPConnection
from threading import Event, Thread
from typing import Any, NamedTuple
from uuid import uuid4

import can

from canopen_twins import devices
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.bus.python_can import message_of
from canopen_twins.bus.segment import Segment
from canopen_twins.faults import connect
from canopen_twins.live.control import control_port
from canopen_twins.live.orders import Orders
from canopen_twins.live.serve import serve

PATIENCE = 30.0
JSON = {"Content-Type": "application/json"}


class Answer(NamedTuple):
    status: int
    body: Any


class Port:
    """Says what curl would, each time by a connection of its own."""

    def __init__(self, address, **bus):
        self.address = address
        self.bus = bus

    def __call__(self, method, path, body=None, **headers):
        raw = body if isinstance(body, bytes) else None if body is None else json.dumps(body)
        said = {**JSON, **{key.replace("_", "-"): value for key, value in headers.items()}}
        connection = HTTPConnection(self.address.host, self.address.port, timeout=PATIENCE)
        try:
            connection.request(method, path, raw, said)
            answer = connection.getresponse()
            return Answer(answer.status, json.loads(answer.read()))
        finally:
            connection.close()

    def get(self, path, **headers):
        return self("GET", path, **headers)

    @contextmanager
    def events(self, query=""):
        """What comes as server-sent events, each as its kind and its content."""
        connection = HTTPConnection(self.address.host, self.address.port, timeout=PATIENCE)
        try:
            connection.request("GET", f"/events{query}")
            answer = connection.getresponse()
            assert answer.status == 200, answer.read()
            assert answer.readline() == b": these are the events\n"
            yield map(json.loads, _data(answer))
        finally:
            connection.close()

    @contextmanager
    def master(self):
        """Somebody else on the bus, who sends frames in the notation of cansend."""
        with can.Bus(**self.bus) as bus:
            yield lambda text: bus.send(message_of(Frame.parse(text)))


def _data(lines):
    for line in lines:
        if line.startswith(b"data: "):
            yield line[6:]


@contextmanager
def served(nodes, token=""):
    """The port of some nodes, each a device and its settings; a bug comes out at the end."""
    channel, segment, orders = uuid4().hex, Segment(), Orders()
    for name, (device, settings) in nodes.items():
        connect(segment, devices.create(device, **settings), name).power_on()
    ready, stop, bugs = Event(), Event(), []

    def work():
        try:
            bus = {"interface": "virtual", "channel": channel}
            serve(segment, lambda: can.Bus(**bus), stop.is_set, ready.set, orders)
        except BaseException as bug:
            bugs.append(bug)
            ready.set()

    thread = Thread(target=work)
    with control_port(segment, orders, HubAddress(port=0), token) as address:
        thread.start()
        assert ready.wait(PATIENCE)
        try:
            yield Port(address, interface="virtual", channel=channel)
        finally:
            stop.set()
            thread.join(PATIENCE)
    assert not bugs, bugs
