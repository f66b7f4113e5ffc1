"""What the scenarios have to prove: a row for each thing that can go wrong with a device."""

import csv
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

from canopen_twins import devices
from canopen_twins.bus.segment import Segment
from canopen_twins.device.device import BitMessage, EmcyMessage, Message
from canopen_twins.device.faults import Fault
from canopen_twins.faults import connect
from canopen_twins.scenario.values import Range
from tools.proofs import Fact, Injected, Proof, Told, Value, shipped

FOLDER = Path(__file__).parent
OF_DEVICE = "device"


class Row(NamedTuple):
    """One thing, and whether a scenario proves it."""

    name: str
    text: str
    proven: Callable[[Proof], bool]


def stories(device: str) -> Iterator[Row]:
    """The statements of DEVICE_stories.csv, which a scenario says it is about."""
    with (FOLDER / f"{device}_stories.csv").open(newline="", encoding="ascii") as file:
        for row in csv.DictReader(file):
            text = f"{row['story']} [{row['section']}]"
            yield Row(row["statement"], text, partial(_covers, row["statement"]))


def messages(device: str) -> Iterator[Row]:
    """What the device can tell: a scenario has expected it, and it came."""
    for name, message in devices.create(device).messages.items():
        yield Row(name, message.text, partial(_any, device, partial(_tells, message)))
        if isinstance(message, BitMessage):
            yield Row(f"{name} gone", "told no longer", partial(_goes, device, message))


def faults(device: str) -> Iterator[Row]:
    """The faults of the device itself: a scenario lets them happen and looks at what follows."""
    for name, fault in _known(device).items():
        if fault.level == OF_DEVICE:
            yield Row(f"`{name}`", fault.text, partial(_any, device, partial(_is, name)))


def faults_of_all() -> Iterator[Row]:
    """The faults that every device has; one device is enough."""
    for name, fault in _known(shipped()[0]).items():
        if fault.level != OF_DEVICE:
            yield Row(f"`{name}`", fault.text, partial(_anywhere, partial(_is, name)))


def _known(device: str) -> dict[str, Fault]:
    return dict(connect(Segment(), devices.create(device), device).faults.known)


def _covers(statement: str, proof: Proof) -> bool:
    return statement in proof.covers


def _any(device: str, fits: Callable[[Fact], bool], proof: Proof) -> bool:
    return any(map(fits, proof.facts.get(device, ())))


def _anywhere(fits: Callable[[Fact], bool], proof: Proof) -> bool:
    return any(_any(device, fits, proof) for device in proof.facts)


def _is(fault: str, fact: Fact) -> bool:
    return fact == Injected(fault)


def _tells(message: Message, fact: Fact) -> bool:
    match message, fact:
        case EmcyMessage(_, code, b""), Told():
            return fact.code == code
        case EmcyMessage(_, code, field), Told(_, int(detail)):
            return fact.code == code and _bytes(detail).startswith(field)
        case BitMessage(), _:
            return _bit(message, fact) == 1
    return False


def _goes(device: str, message: BitMessage, proof: Proof) -> bool:
    """Whether the bit was seen set, and further down the file it was not."""
    seen = [_bit(message, fact) for fact in proof.facts.get(device, ())]
    return 1 in seen and 0 in seen[seen.index(1) :]


def _bit(message: BitMessage, fact: Fact) -> int | None:
    """What a fact says of a bit, if it does."""
    match fact:
        case Value(target, Range(low, high)) if low == high and target.address == message.address:
            return int(low) >> message.bit & 1
    return None


def _bytes(detail: int) -> bytes:
    return detail.to_bytes(5, "little")
