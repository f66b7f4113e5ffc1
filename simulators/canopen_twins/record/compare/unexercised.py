"""What a trace has not shown of a twin: objects nobody asked for, services nobody used."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field

from canopen_twins.bus import identifiers
from canopen_twins.bus.sdo import Address
from canopen_twins.bus.wire import Heard
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.decoder import COMMANDS
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.rpdo import Rpdo
from canopen_twins.slave.slave import Slave
from canopen_twins.slave.tpdo import Tpdo

MOST_OBJECTS = 20


@dataclass
class Exercised:
    """Of one node, filled while the trace is played."""

    objects: set[Address] = field(default_factory=set)
    commands: set[int] = field(default_factory=set)
    """Of NMT."""
    heard: set[Heard] = field(default_factory=set)
    """Identifiers of the master."""


def unexercised(node: Node, done: Exercised, services: Collection[str]) -> Iterator[str]:
    """In words, one line for a kind; `services` are those that were compared.

    Nothing is known of a node that is silent at the end.
    """
    slave = node.slave
    if slave is None:
        return
    if commands := [words for code, words in COMMANDS.items() if code not in done.commands]:
        yield f"NMT {', '.join(commands)}"
    if others := list(_services(node, slave, done, services)):
        yield f"services: {', '.join(others)}"
    entries = [entry for record in slave.entries.values() for entry in record.values()]
    rest = [address_text(each.address) for each in entries if each.address not in done.objects]
    if rest:
        more = f" and {len(rest) - MOST_OBJECTS} more" if len(rest) > MOST_OBJECTS else ""
        count = f"{len(rest)} of {len(entries)} objects by SDO"
        yield f"{count}: {', '.join(rest[:MOST_OBJECTS])}{more}"


def _services(
    node: Node, slave: Slave, done: Exercised, services: Collection[str]
) -> Iterator[str]:
    offered = {
        "heartbeat": slave.has(0x1017) or slave.has(0x100C),
        "EMCY": node.device.has_emergencies,
        "LSS": _hears(slave, (identifiers.LSS_REQUEST, False)),
        **{f"TPDO{n}": Tpdo.identifier(slave, n) is not None for n in Tpdo.numbers(slave)},
    }
    yield from (name for name, there in offered.items() if there and name not in services)
    for number in Rpdo.numbers(slave):
        can_id = Rpdo.identifier(slave, number)
        if can_id is not None and (can_id, False) not in done.heard:
            yield f"RPDO{number}"
    guards = identifiers.heartbeat(node.node_id), True
    for name, key in {"SYNC": (identifiers.SYNC, False), "node guarding": guards}.items():
        if _hears(slave, key) and key not in done.heard:
            yield name


def _hears(slave: Slave, key: Heard) -> bool:
    return slave.wire.heard is not None and key in slave.wire.heard
