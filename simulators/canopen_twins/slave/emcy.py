"""Emergencies: the messages, their tables, and the producer that reports what has changed."""

import csv
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial, reduce
from operator import or_
from typing import NamedTuple

from canopen_twins.bus import identifiers
from canopen_twins.bus.frame import Frame
from canopen_twins.files.shipped import od_file
from canopen_twins.slave.object import Address, Object, Rejected
from canopen_twins.slave.service import Service, State, check_cob_id_change
from canopen_twins.slave.slave import Slave

EMCY_LENGTH, FIELD_LENGTH = 8, 5  # bytes: all of it, and the manufacturer-specific error field
BIT_30 = 1 << 30

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
    return identifiers.of_cob_id(slave.number(0x1014) if slave.has(0x1014) else default)


def emcy_data(emcy: Emcy, bits: int) -> bytes:
    """A message as it goes over the wire, with the error register of the moment."""
    return emcy.code.to_bytes(2, "little") + bytes([bits]) + emcy.field


def emcy_of(data: bytes) -> Emcy:
    """A message as it comes over the wire; what is too short ends in zeros."""
    whole = data.ljust(EMCY_LENGTH, b"\0")
    return Emcy(int.from_bytes(whole[:2], "little"), whole[2], whole[3:])


class EmcyProducer(Service):
    """Tells every error once, keeps 0x1001 and 0x1003, and says when it is over.

    While the node is stopped the objects follow at once and the messages wait; an error that has
    gone by then is not told any more.
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

    @property
    def eventful(self) -> bool:
        """Errors come and go with every frame and every step."""
        return True

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Error register, error history as deep as the dictionary has it, and COB-ID."""
        entries = {(0x1001, 0): Object(read=lambda: self.log.register)}
        if self._depth:
            entries[0x1003, 0] = Object(read=lambda: len(self.log.history), write=self._erase)
        for age in range(self._depth):
            entries[0x1003, age + 1] = Object(read=partial(self._past, age))
        entries[0x1014, 0] = Object(write=self._check_cob_id)
        return {address: acts for address, acts in entries.items() if self.slave.has(*address)}

    def on_state(self, state: State) -> None:
        """Nothing is sent in Stopped (CiA 301, table 37)."""
        self._sending = state in (State.PRE_OPERATIONAL, State.OPERATIONAL)

    def publish(self) -> None:
        """Follow what is wrong, and tell how it differs from what was told."""
        now = self._emergencies()
        if now != self.log.active:
            self._follow(tuple(now))
        if self._sending and self.log.told != self.log.active:
            self._tell()

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
        cob_id = emcy_id(self.slave)
        if not self.slave.has(0x1001):
            bits = 0  # what is not there is not told
        if cob_id is not None:
            self.slave.send(Frame(cob_id, emcy_data(emcy, bits)))

    def _check_cob_id(self, value: int) -> None:
        if value & BIT_30:
            raise Rejected("bit 30 of an emergency is always 0")
        check_cob_id_change(self.slave.number(0x1014), value)

    @property
    def _depth(self) -> int:
        """The highest sub-index: there may be gaps below it."""
        return max(self.slave.entries.get(0x1003, {0: None}))

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
