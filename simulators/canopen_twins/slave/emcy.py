"""Emergencies: the messages, their tables, and who reports what has changed and who hears it."""

import csv
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial, reduce
from operator import or_
from typing import NamedTuple

from canopen_twins.bus import identifiers
from canopen_twins.bus.clock import Timer
from canopen_twins.bus.frame import Frame
from canopen_twins.files.shipped import od_file
from canopen_twins.slave.object import Address, Object, Rejected
from canopen_twins.slave.service import (
    Listening,
    Service,
    State,
    check_cob_id_change,
    give_default,
)
from canopen_twins.slave.slave import Slave

EMCY_LENGTH, FIELD_LENGTH = 8, 5  # bytes: all of it, and the manufacturer-specific error field
BIT_30 = 1 << 30
COMMUNICATION = 0x11  # register: a generic error, one of communication (CiA 301, 7.5.2.2)

Key = tuple[int, int]  # emergency error code, manufacturer-specific error field


class Emcy(NamedTuple):
    """An error as it is told: its code, its bits of the error register, its error field."""

    code: int
    register: int
    field: bytes = bytes(FIELD_LENGTH)
    label: str = ""

    @property
    def detail(self) -> int:
        """The error field as one number, its first byte the lowest."""
        return int.from_bytes(self.field, "little")

    def is_like(self, other: "Emcy") -> bool:
        """Whether both tell the same, whatever the register of the moment."""
        return (self.code, self.detail) == (other.code, other.detail)


NO_ERROR = Emcy(0x0000, 0x00, label="no error")


def read_emcy_table(name: str) -> Mapping[Key, Emcy]:
    """A table of od/: one row per message of the manual.

    Raises:
        ValueError: a row stands there twice.
    """
    table: dict[Key, Emcy] = {}
    with od_file(name) as path, path.open(newline="", encoding="ascii") as file:
        for row in csv.DictReader(file):
            code, register, detail = (int(row[key], 16) for key in ("code", "register", "detail"))
            if (code, detail) in table:
                raise ValueError(f"{name}: {row} stands there twice")
            content = detail.to_bytes(FIELD_LENGTH, "little")
            table[code, detail] = Emcy(code, register, content, row["label"])
    return table


Farewell = Callable[[Emcy, int], Emcy | None]


def when_all_are_gone(gone: Emcy, register: int) -> Emcy | None:
    """One "no error" once nothing is left: what CiA 301 asks for at least."""
    return None if register else NO_ERROR


@dataclass
class EmcyLog:
    """What outlives a reset of the communication: errors, what the master knows, the history."""

    active: Sequence[Emcy] = ()
    told: Sequence[Emcy] = ()
    history: list[Emcy] = field(default_factory=list)
    waiting: deque[bytes] = field(default_factory=deque)
    """Messages that the inhibit time holds back."""

    @property
    def register(self) -> int:
        """The error register 0x1001: the bits of every active error."""
        return register(self.active)


def register(errors: Iterable[Emcy]) -> int:
    """The error register of some errors."""
    return reduce(or_, (emcy.register for emcy in errors), 0)


def emcy_id(slave: Slave) -> int | None:
    """The identifier of its emergencies; none while they are switched off."""
    default = identifiers.emcy(slave.node_id)
    said = slave.number(0x1014) if slave.has(0x1014) else 0
    return identifiers.of_cob_id(said or default)


def emcy_data(emcy: Emcy, bits: int) -> bytes:
    """A message as it goes over the wire, with the error register of the moment."""
    return emcy.code.to_bytes(2, "little") + bytes([bits]) + emcy.field


def emcy_of(data: bytes) -> Emcy:
    """A message as it comes over the wire; what is too short ends in zeros."""
    whole = data.ljust(EMCY_LENGTH, b"\0")
    return Emcy(int.from_bytes(whole[:2], "little"), whole[2], whole[3:])


class EmcyProducer(Service):
    """Tells every error once, keeps 0x1001 and 0x1003, and says when it is over.

    Errors are those of the device, then those of its communication: see `Slave.errors`.
    While the node is stopped the objects follow at once and the messages wait; an error that has
    gone by then is not told any more. Between two messages passes the inhibit time of 0x1015.
    """

    def __init__(
        self,
        slave: Slave,
        log: EmcyLog,
        emergencies: Callable[[], Sequence[Emcy]],
        farewell: Farewell = when_all_are_gone,
    ) -> None:
        super().__init__(slave)
        self.log = log
        self._emergencies = emergencies
        self._farewell = farewell
        self._sending = False
        self._inhibit: Timer | None = None
        self._depth = max(slave.entries.get(0x1003, {0: None}))
        give_default(slave, (0x1014, 0), identifiers.emcy(slave.node_id))

    @property
    def eventful(self) -> bool:
        """Errors come and go with every frame and every step."""
        return True

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Error register, error history as deep as the dictionary has it, and COB-ID."""
        entries: dict[Address, Object] = {}
        if self._has_register:
            entries[0x1001, 0] = Object(read=lambda: self.log.register)
        if self._depth:
            entries[0x1003, 0] = Object(read=lambda: len(self.log.history), write=self._erase)
        for subindex in self.slave.entries.get(0x1003, ()):
            if subindex:
                entries[0x1003, subindex] = Object(read=partial(self._past, subindex - 1))
        if self.slave.has(0x1014):
            entries[0x1014, 0] = Object(write=self._check_cob_id)
        return entries

    def on_state(self, state: State) -> None:
        """Nothing is sent in Stopped (CiA 301, table 37)."""
        self._sending = state in (State.PRE_OPERATIONAL, State.OPERATIONAL)

    def publish(self) -> None:
        """Follow what is wrong, and tell how it differs from what was told."""
        now = self._emergencies()
        if self.slave.errors:
            now = (*now, *self._of_communication())
        if now != self.log.active:
            self._follow(tuple(now))
        if self._sending and self.log.told != self.log.active:
            self._tell()
        if self.log.waiting:
            self._send_waiting()

    def _of_communication(self) -> Iterator[Emcy]:
        for why, code in self.slave.errors.items():
            yield Emcy(code, COMMUNICATION, label=why)

    def _follow(self, now: Sequence[Emcy]) -> None:
        before, self.log.active = self.log.active, now
        for new in (emcy for emcy in now if emcy not in before):
            self.log.history = [new, *self.log.history][: self._depth]

    def _tell(self) -> None:
        before, self.log.told = self.log.told, self.log.active
        left = [*before, *(emcy for emcy in self.log.told if emcy not in before)]
        for gone in (emcy for emcy in before if emcy not in self.log.told):
            left.remove(gone)
            if farewell := self._farewell(gone, register(left)):
                self._send(farewell, farewell.register)
        for new in (emcy for emcy in self.log.told if emcy not in before):
            self._send(new, self.log.register)

    def _send(self, emcy: Emcy, bits: int) -> None:
        self.log.waiting.append(emcy_data(emcy, bits if self._has_register else 0))
        self._send_waiting()

    def _send_waiting(self) -> None:
        while self.log.waiting and self._sending and self._inhibit is None:
            data, cob_id = self.log.waiting.popleft(), emcy_id(self.slave)
            if cob_id is None:
                continue
            self.slave.send(Frame(cob_id, data))
            if time := self.slave.number(0x1015) if self.slave.has(0x1015) else 0:
                self._inhibit = self.slave.clock.after(time / 10_000, self._on_free)

    def _on_free(self) -> None:
        self._inhibit = None
        self._send_waiting()

    @property
    def _has_register(self) -> bool:
        return self.slave.has(0x1001)

    def _check_cob_id(self, value: int) -> None:
        if value & BIT_30:
            raise Rejected("bit 30 of an emergency is always 0")
        check_cob_id_change(self.slave.number(0x1014), value)

    def _past(self, age: int) -> int:
        if age >= len(self.log.history):
            if (code := self.slave.profile.no_history_code) is not None:
                raise Rejected("no such error in the history", code)
            return 0
        emcy = self.log.history[age]
        return emcy.code | int.from_bytes(emcy.field[:2], "little") << 16

    def _erase(self, value: int) -> None:
        if value:
            raise Rejected(f"0 erases the history, {value} does nothing")
        self.log.history.clear()


class EmcyConsumer(Service):
    """Hears the emergencies of the nodes that 0x1028 names by its sub-indices (7.5.2.24).

    Whoever is told hears of a node with its id and its emergency.
    """

    active_in = frozenset({State.PRE_OPERATIONAL, State.OPERATIONAL})

    def __init__(self, slave: Slave, tell: Callable[[int, Emcy], None]) -> None:
        super().__init__(slave)
        self._tell = tell
        self._named = [
            sub for sub, entry in slave.entries.get(0x1028, {}).items() if sub and entry.is_whole
        ]
        for subindex in self._named:
            give_default(slave, (0x1028, subindex), identifiers.INVALID)

    @property
    def objects(self) -> Mapping[Address, Object]:
        """An identifier changes while it is off."""
        return {(0x1028, sub): Object(write=partial(self._check, sub)) for sub in self._named}

    def listen(self) -> Listening:
        """The emergencies that are not switched off."""
        for node_id in self._named:
            cob_id = identifiers.of_cob_id(self.slave.number(0x1028, node_id))
            if cob_id is not None:
                yield (cob_id, False), partial(self._on_emcy, node_id)

    def _on_emcy(self, node_id: int, frame: Frame) -> None:
        if len(frame.data) == EMCY_LENGTH:
            self._tell(node_id, emcy_of(frame.data))

    def _check(self, subindex: int, value: int) -> None:
        check_cob_id_change(self.slave.number(0x1028, subindex), value)
