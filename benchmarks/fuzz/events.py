"""Events of a random life: frames, faults, times, NMT, power and settings, by a seed."""

from collections.abc import Iterator, Mapping
from dataclasses import fields
from math import isfinite
from random import Random
from typing import Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

from canopen_twins.bus import identifiers, sdo
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.sdo import Ccs
from canopen_twins.device.device import Device
from canopen_twins.device.faults import Fault, Parameter
from canopen_twins.device.node import Node
from canopen_twins.device.settings import About, about


class Send(NamedTuple):
    """A frame from outside."""

    frame: Frame


class Wait(NamedTuple):
    """Time passes."""

    seconds: float


class Inject(NamedTuple):
    """Something goes wrong."""

    fault: str
    parameters: Mapping[str, Any]


class Clear(NamedTuple):
    """All of it is taken away."""


class Power(NamedTuple):
    """The supply is switched."""

    on: bool


class Change(NamedTuple):
    """Live settings become others."""

    settings: Mapping[str, Any]


OF_DEVICE = "device"  # level of faults that leave what is on the bus right

Event = Send | Wait | Inject | Clear | Power | Change

NMT_COMMANDS = (0x01, 0x02, 0x80, 0x81, 0x82)
LSS_COMMANDS = (0x04, *range(0x40, 0x4D), 0x11, 0x13, 0x17, 0x51, 0x5A, 0x5E)
EDGES = (0, 1, 2, 0x7F, 0x80, 0xFF, 0x100, 0x7FFF, 0x8000, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF)
SIGNATURES = (b"save", b"load")
SHORT_WAITS = (0.000_001, 0.001, 0.01, 0.02)
WAITS = (*SHORT_WAITS, 0.1, 0.3, 1.0)
TEXTS = ("", "1", "open", "resistor 4", "short", "battery 48 0.1")
AT_MOST = {float: 1e6, int: 1 << 16}


class Frames:
    """Frames for one node, most of them such that it has something to do with them."""

    def __init__(self, node: Node, random: Random) -> None:
        self._node = node
        self._random = random
        self._kinds = (
            *(self._read,) * 4,
            *(self._write,) * 8,
            *(self._segment,) * 2,
            self._heartbeat,
            self._garbled,
            self._block,
            self._pdo,
            self._pdo,
            self._asked,
            self._service,
            self._anything,
        )

    def __iter__(self) -> Iterator[Frame]:
        while True:
            yield self.one()

    def one(self) -> Frame:
        """The next one; a command of NMT now and then."""
        random = self._random
        if random.random() < 0.005:
            return self.nmt()
        return random.choice(self._kinds)()

    def nmt(self) -> Frame:
        """A command to this node, to all, or to another."""
        command = self._random.choice(
            (*NMT_COMMANDS, 0x01, 0x01, 0x80, self._random.randrange(256))
        )
        target = self._random.choice((self._node.node_id, self._node.node_id, 0, 1, 127))
        return Frame(identifiers.NMT, bytes([command, target]))

    def _bytes(self, most: int = 8) -> bytes:
        return self._random.randbytes(self._random.randint(0, most))

    def _address(self) -> sdo.Address:
        slave, random = self._node.slave, self._random
        if slave is None or random.random() < 0.05:
            return random.randrange(0x10000), random.randrange(256)
        index = random.choice([*slave.entries])
        if random.random() < 0.05:
            return index, random.randrange(256)
        return index, random.choice([*slave.entries[index]])

    def _request(self, data: bytes) -> Frame:
        return Frame(identifiers.sdo_request(self._node.node_id), data)

    def _read(self) -> Frame:
        return self._request(sdo.message(Ccs.UPLOAD, sdo.multiplexer(self._address())))

    def _write(self) -> Frame:
        """Mostly of the right length, often at an edge."""
        random, address = self._random, self._address()
        slave = self._node.slave
        size = random.randint(1, 4)
        if slave is not None and slave.has(*address) and random.random() < 0.9:
            size = min(slave.entry(*address).size or size, 4)
        value = random.choice((*EDGES, random.randrange(1 << 32), random.randrange(5000)))
        data = (value & (1 << 8 * size) - 1).to_bytes(size, "little")
        if size == 4 and random.random() < 0.05:
            data = random.choice(SIGNATURES)
        named = sdo.multiplexer(address)
        return self._request(sdo.expedited(Ccs.DOWNLOAD, named, data, random.random() < 0.9))

    def _heartbeat(self) -> Frame:
        """A period, or none."""
        time = self._random.choice((0, 10, 100, 500)).to_bytes(2, "little")
        return self._request(sdo.expedited(Ccs.DOWNLOAD, sdo.multiplexer((0x1017, 0)), time))

    def _segment(self) -> Frame:
        """An initiate of a segmented transfer, or a segment of whatever is open."""
        random = self._random
        if random.random() < 0.3:
            named = sdo.multiplexer(self._address())
            return self._request(sdo.announcing(Ccs.DOWNLOAD, named, random.randint(0, 20)))
        command = random.choice((0x00, 0x10, 0x01, 0x11, 0x0D, 0x60, 0x70, 0x80))
        return self._request((bytes([command]) + random.randbytes(7))[:8])

    def _block(self) -> Frame:
        """Of a block transfer: an initiate, or what follows on one."""
        random = self._random
        command = random.choice((0xA0, 0xA4, 0xA1, 0xA2, 0xA3, 0xC0, 0xC2, 0xC6, 0xC1, 1, 2, 0x81))
        named = sdo.multiplexer(self._address())
        return self._request(bytes([command]) + named + random.randbytes(4))

    def _garbled(self) -> Frame:
        return self._request(self._bytes())

    def _pdo(self) -> Frame:
        can_id = self._random.choice((0x200, 0x300, 0x400, 0x500)) + self._node.node_id
        return Frame(can_id, self._bytes())

    def _asked(self) -> Frame:
        base = self._random.choice((0x080, 0x180, 0x280, 0x380, 0x480, 0x580, 0x700))
        return Frame(base + self._node.node_id, remote=True)

    def _service(self) -> Frame:
        """SYNC, TIME, heartbeats and emergencies of others, LSS."""
        random = self._random
        other = random.randint(1, 127)
        return random.choice(
            (
                Frame(identifiers.SYNC),
                Frame(identifiers.SYNC, random.randbytes(1)),
                Frame(identifiers.TIME, random.randbytes(6)),
                Frame(identifiers.heartbeat(other), random.choice((b"\0", b"\4", b"\5", b"\x7f"))),
                Frame(identifiers.emcy(other), random.randbytes(8)),
                self._lss(),
            )
        )

    def _lss(self) -> Frame:
        """What would take the node off the bus for minutes, 15h with a long delay, is left out."""
        command = self._random.choice(
            (0x04, *range(0x40, 0x4D), 0x11, 0x13, 0x17, 0x51, 0x5A, 0x5E)
        )
        return Frame(identifiers.LSS_REQUEST, bytes([command]) + self._random.randbytes(7))

    def _anything(self) -> Frame:
        extended = self._random.random() < 0.2
        can_id = self._random.randrange(1 << 29 if extended else 1 << 11)
        remote = self._random.random() < 0.1
        return Frame(can_id, b"" if remote else self._bytes(), remote, extended)


def inject(known: Mapping[str, Fault], random: Random) -> Inject:
    """A fault, with parameters that may be refused; most leave what is on the bus right."""
    own = sorted(name for name, fault in known.items() if fault.level == OF_DEVICE)
    name = random.choice(own if own and random.random() < 0.7 else sorted(known))
    parameters = known[name].parameters.items()
    return Inject(
        name,
        {
            key: _parameter(told, random)
            for key, told in parameters
            if told.default is None or random.random() < 0.3
        },
    )


def _parameter(told: Parameter, random: Random) -> object:
    if told.examples and random.random() < 0.7:
        return random.choice(told.examples)
    if told.kind in AT_MOST:
        return _number(told.kind, told.low, told.high, random)
    return random.choice(TEXTS)


def _number(kind: Any, low: float, high: float, random: Random) -> float:
    low = low if isfinite(low) else 0
    high = high if isfinite(high) else max(low, 0) + random.choice((10, 1000, AT_MOST[kind]))
    value = random.uniform(low, high)
    return int(value) if kind is int else round(value, 3)


def change(device: Device, random: Random) -> Change | None:
    """Another value of a live setting; none if the device has no live settings."""
    types = get_type_hints(type(device.settings))
    live = [each for each in fields(device.settings) if about(each).live]
    if not live:
        return None
    chosen = random.choice(live)
    return Change({chosen.name: _setting(types[chosen.name], about(chosen), random)})


def _setting(kind: Any, told: About, random: Random) -> object:
    if get_origin(kind) is Literal:
        return random.choice(get_args(kind))
    if kind is bool:
        return random.random() < 0.5
    if kind in AT_MOST:
        return _number(kind, told.low, told.high, random)
    return random.choice(TEXTS)
