"""The handle on one running twin, the same on a bench, on a bus in real time and from afar."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from itertools import chain
from typing import Any

from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError, unknown
from canopen_twins.slave.dictionary import Names, address_text
from canopen_twins.slave.object import Entry, Rejected


class Twin(ABC):
    """What is done and asked here, whoever drives the twin carries out between two frames.

    How that gets there is all that a kind of twin adds: it is a word of `ORDERS` or `QUESTIONS` and
    what goes with it, so that it can go to another thread or another process.
    """

    @abstractmethod
    def order(self, word: str, *arguments: Any) -> None:
        """Have one of `ORDERS` carried out; what it brings about has been sent when this returns.

        Raises:
            UserError: as the order does.
        """

    @abstractmethod
    def ask(self, word: str, *arguments: Any) -> Any:
        """The answer to one of `QUESTIONS`; nothing is sent.

        Raises:
            UserError: as the question does.
        """

    @property
    def node_id(self) -> int:
        """The node id in force, or the one to boot with."""
        return int(self.ask("node_id"))

    @property
    def state(self) -> str:
        """The NMT state by the name canopen gives it; INITIALISING while the twin is silent."""
        return str(self.ask("state"))

    @property
    def report(self) -> Mapping[str, object]:
        """How the model is at this moment, in engineering units."""
        report: Mapping[str, object] = self.ask("report")
        return report

    def values(self, *wanted: str) -> Mapping[str, object]:
        """Entries of the dictionary by their names in the EDS, read without a frame on the bus.

        An address such as 0x1018:01 will do as well; it is the name of those that share theirs with
        another. Without a name all that a master can read; none while the twin is silent.

        Raises:
            UserError: there is no such entry that can be read, or there are several.
        """
        values: Mapping[str, object] = self.ask("values", wanted)
        return values

    @property
    def powered(self) -> bool:
        """Whether its supply is on."""
        return bool(self.ask("powered"))

    @property
    def settings(self) -> Mapping[str, object]:
        """The settings in force."""
        settings: Mapping[str, object] = self.ask("settings")
        return settings

    @property
    def active_faults(self) -> Mapping[str, Mapping[str, Any]]:
        """The faults that are there, each with its parameters."""
        active: Mapping[str, Mapping[str, Any]] = self.ask("active_faults")
        return active

    def inject(self, name: str, *values: object, **parameters: Any) -> None:
        """Let something go wrong.

        Raises:
            UserError: no such fault or parameter, or a value without the name of its parameter.
        """
        if values:
            told = f"inject({name!r}, NAME={values[0]!r})"
            raise UserError(f"parameters have names, say which: {told}; `canopen-twin faults`")
        self.order("inject", name, parameters)

    def clear(self, name: str | None = None) -> None:
        """Take one fault away, or all of them.

        Raises:
            UserError: no such fault.
        """
        self.order("clear", name)

    def set(self, /, **settings: object) -> None:
        """Change live settings, such as the load.

        Of a device that a file describes also objects, by their names or addresses: what it
        measures. A setting of the same name comes first.

        Raises:
            UserError: no such setting or object, a wrong value, or one taken over at power-on only.
        """
        self.order("set", settings)

    def power_off(self) -> None:
        """Switch the supply off."""
        self.order("power_off")

    def power_on(self, /, **settings: object) -> None:
        """Switch the supply on, with other settings if any are given.

        Raises:
            UserError: no such setting, a wrong value, or the power is on already.
        """
        self.order("power_on", settings)


def _inject(node: Node, name: str, parameters: Mapping[str, Any]) -> None:
    with node.acting():
        node.faults.inject(name, **parameters)


def _clear(node: Node, name: str | None) -> None:
    with node.acting():
        node.faults.clear(name)


def _set(node: Node, settings: Mapping[str, object]) -> None:
    with node.acting() as device:
        device.set(**settings)


def _power_on(node: Node, settings: Mapping[str, object]) -> None:
    if settings and node.powered:
        raise UserError(f"the power is on: switch it off to change {', '.join(settings)}")
    if settings:
        node.device.configure(**settings)
    node.power_on()


def each_value(node: Node, wanted: Sequence[str]) -> Iterator[tuple[str, object]]:
    """What `Twin.values` gives, one by one."""
    node.look()
    if wanted and node.slave is None:
        raise UserError(f"{wanted[0]} cannot be read: the node is silent")
    objects = {} if node.slave is None else node.slave.entries
    readable = [
        entry for entry in chain.from_iterable(map(dict.values, objects.values())) if entry.readable
    ]
    names = Names((entry.variable.qualname, entry.address, entry) for entry in readable)
    addresses = {address_text(entry.address): entry for entry in readable}
    for name in wanted or [_told(entry, names) for entry in readable]:
        if name not in names and name not in addresses:
            raise unknown("object", name, names)
        entry = addresses.get(name) or names[name]
        with suppress(Rejected):  # a master would be refused, too
            yield name, entry.unpack(entry.read())


def _told(entry: Entry, names: Names[Entry]) -> str:
    """The name of an entry; its address if others have that name, too."""
    name: str = entry.variable.qualname
    return address_text(entry.address) if names.is_of_several(name) else name


QUESTIONS: Mapping[str, Callable[..., Any]] = {
    "node_id": lambda node: node.node_id,
    "state": lambda node: str(node.state),
    "report": lambda node: dict(node.look().report),
    "values": lambda node, wanted: dict(each_value(node, wanted)),
    "settings": lambda node: asdict(node.device.settings),
    "active_faults": lambda node: dict(node.faults.active),
    "powered": lambda node: node.powered,
}
"""What is asked of a node, each with the node first."""

ORDERS: Mapping[str, Callable[..., None]] = {
    "inject": _inject,
    "clear": _clear,
    "set": _set,
    "power_off": Node.power_off,
    "power_on": _power_on,
}
"""What is done to a node, each with the node first."""


def carry_out(segment: Segment[Node], node: Node, word: str, *arguments: Any) -> int:
    """Do one of `ORDERS` between two frames of a segment; who listens to its orders hears it.

    Returns:
        Its moment, in microseconds of the segment's clock; what it brings about has been sent.

    Raises:
        UserError: as the order does.
    """
    segment.advance_to(segment.clock.now)  # what the last frame has set off at once comes before
    for listener in segment.order_listeners:
        listener(node.wire.name, word, arguments)
    ORDERS[word](node, *arguments)
    segment.deliver()
    return segment.clock.ticks
