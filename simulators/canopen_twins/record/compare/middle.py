"""What a twin takes over of a device that a trace shows in the middle of its life."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress

from canopen_twins.bus import identifiers
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.sdo import Address
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.record.compare.dialogue import Transfer, outcome
from canopen_twins.record.compare.judge import Judge
from canopen_twins.slave.nmt import TARGET
from canopen_twins.slave.object import Entry, Rejected
from canopen_twins.slave.pdo import carried
from canopen_twins.slave.rpdo import Rpdo
from canopen_twins.slave.service import State

A_LITTLE = 0.05  # of a period
MILLISECOND = 1_000
COMMANDS = {state: command for command, state in TARGET.items()}


class Middle:
    """Of one node. What a master must have written or commanded before is done to the twin."""

    def __init__(self, judge: Judge, segment: Segment[Node]) -> None:
        self.node = judge.node
        self.is_here = False
        """Whether it is not known what came before: the device has not booted in the trace."""
        self.knows_state = False
        """Whether the NMT master has said what the state is."""
        self.is_deaf = False
        """Whether what the twin sends now is of no interest."""
        self.written: set[Address] = set()
        """Objects of which it is known what is in them."""
        self.unknown: set[Address] = set()
        """Objects that were written with what the trace lacks."""
        self.pdos: set[int] = set()
        """Identifiers of the master that may be those of PDOs."""
        self._judge = judge
        self._segment = segment
        self._beat: int | None = None  # the last heartbeat of the device
        self._beats = False  # whether its period is known

    def end(self) -> None:
        """The device has booted: from now on everything is known."""
        self.is_here, self.knows_state = False, True
        self.written.clear()

    def infer(self, state: State | None) -> bool:
        """Take over the NMT state that the device shows, if it is new.

        What it shows it with had no cause that the twin could know.
        """
        if self.knows_state or not self.is_here or state in (None, self.node.state):
            return False
        assert state is not None
        command = bytes([COMMANDS[state], self.node.node_id])
        with self.unheard():
            self._segment.send(Frame(identifiers.NMT, command))
        return True

    def infer_period(self, tick: int) -> bool:
        """Take over the period of the heartbeat, if it is new."""
        if not self.is_here:
            return False
        last, self._beat = self._beat, tick
        entry = self._judge.entry((0x1017, 0))
        if last is None or entry is None or not entry.writable or entry.address in self.written:
            return False
        seen, period = (tick - last) / MILLISECOND, int(entry.unpack(entry.read()))
        longer = seen > (1 - A_LITTLE) * period
        if (self._beats and longer) or abs(seen - period) <= A_LITTLE * period:
            return False
        self._beats = True
        self._set(entry, entry.pack(round(seen)))
        return True

    def take_over(self, transfer: Transfer) -> None:
        """What the device has in an object is what was written, if a master may write it."""
        if not (self.is_here or transfer.address in self.unknown):
            return
        told, entry = outcome(transfer.device), self._judge.entry(transfer.address)
        if entry is None or not entry.writable or told.value is None:
            return
        if entry.address in self.written or told.code is not None or self._by_pdo(entry):
            return
        self.unknown.discard(entry.address)
        self.written.add(entry.address)
        if entry.read() == told.value:
            return
        self._set(entry, told.value)
        transfer.twin = list(transfer.device)

    def _by_pdo(self, entry: Entry) -> bool:
        """Whether a PDO of the trace may have brought what is in an object."""
        slave = self.node.slave
        assert slave is not None
        heard = (n for n in Rpdo.numbers(slave) if Rpdo.identifier(slave, n) in self.pdos)
        return any(
            part.entry is entry for n in heard for part in carried(slave, Rpdo.mapping + n - 1)
        )

    def _set(self, entry: Entry, value: bytes) -> None:
        """What a master must have written before the trace began."""
        assert self.node.slave is not None
        with self.unheard(), suppress(Rejected), self.node.acting():
            self.node.slave.write(entry, value)

    @contextmanager
    def unheard(self) -> Iterator[None]:
        """What the twin sends meanwhile is of no interest."""
        self.is_deaf = True
        yield
        self._segment.deliver()
        self.is_deaf = False
