"""Store and restore parameters, and what tells of them: 0x1010, 0x1011, 0x1020 to 0x1022.

CiA 301, 7.5.2.13 to 7.5.2.15, 7.5.2.20 to 7.5.2.22.
"""

import logging
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from math import inf
from typing import Protocol

from canopen_twins.files.shipped import od_file
from canopen_twins.slave.memory import Memory
from canopen_twins.slave.object import Abort, Address, Object, Rejected
from canopen_twins.slave.service import Service, State
from canopen_twins.slave.slave import Slave

log = logging.getLogger(__name__)

SAVE = int.from_bytes(b"save", "little")
LOAD = int.from_bytes(b"load", "little")
ON_COMMAND = 1  # what reading says: stored when told to, not by itself
SECTION = "parameters"
ALL = 1  # sub-index
AREAS = {ALL: range(0x1000, 0x10000), 2: range(0x1000, 0x2000), 3: range(0x6000, 0xA000)}
"""What is stored and restored by sub-index: all, communication, application; see MAKERS."""
MAKERS = {sub: range(0x2000, 0x6000) for sub in range(4, 0x80)}


class Keeper(Protocol):
    """Who keeps what is no entry that can be read and written back. Either may raise `OSError`."""

    def save(self) -> None:
        """Keep it."""

    def restore(self) -> None:
        """Keep the factory settings."""


class Store(Service):
    """Keeps the values of some entries in a memory when the master says so."""

    def __init__(
        self,
        slave: Slave,
        memory: Memory,
        kept: Collection[Address],
        keeper: Keeper,
        busy_time: float = 0.0,
    ) -> None:
        """`busy_time`: seconds for which both commands are refused after each."""
        super().__init__(slave)
        self._memory = memory
        self._kept = kept
        self._keeper = keeper
        self._busy_time = busy_time
        self._free = -inf  # seconds of the clock

    @property
    def objects(self) -> Mapping[Address, Object]:
        """The commands the dictionary has."""
        return {
            (index, sub): Object(read=lambda: ON_COMMAND, write=partial(command, sub))
            for index, command in ((0x1010, self._save), (0x1011, self._restore))
            for sub in self.slave.entries.get(index, ())
            if sub in {*AREAS, *MAKERS}
        }

    def _save(self, subindex: int, signature: int) -> None:
        self._check(signature, SAVE)
        entries = [self.slave.entry(*address) for address in self._of(subindex)]
        data = {_key(entry.address): entry.read().hex() for entry in entries}
        self._store(subindex, data, self._keeper.save)
        self._free = self.slave.clock.now + self._busy_time

    def _restore(self, subindex: int, signature: int) -> None:
        self._check(signature, LOAD)
        self._store(subindex, {}, self._keeper.restore)
        self._free = self.slave.clock.now + self._busy_time
        if self.slave.profile.restore_at_once:
            for entry in (self.slave.entry(*address) for address in self._of(subindex)):
                self.slave.write(entry, entry.initial)

    def _store(
        self, subindex: int, values: Mapping[str, str], keep_others: Callable[[], None]
    ) -> None:
        """Replace what is stored of an area; what only the device knows goes with all there is."""
        with _writing():
            if subindex == ALL:
                self._memory.store(SECTION, values)
                keep_others()
            else:
                its_own = {_key(address) for address in self._of(subindex)}
                before = self._memory.load(SECTION).items()
                rest = {key: value for key, value in before if key not in its_own}
                self._memory.store(SECTION, {**rest, **values})

    def _of(self, subindex: int) -> list[Address]:
        area = AREAS.get(subindex) or MAKERS[subindex]
        return [address for address in self._kept if address[0] in area]

    def _check(self, signature: int, expected: int) -> None:
        profile = self.slave.profile
        if self.slave.clock.now < self._free:
            raise Rejected("it is still storing (store_time)", Abort.HARDWARE)
        if profile.store_signature and signature != expected:
            raise Rejected(f"{signature:08X}h is not the signature", profile.store_code)


@contextmanager
def _writing() -> Iterator[None]:
    try:
        yield
    except OSError as failure:
        log.error("the memory cannot be written: %s", failure)
        raise Rejected("the memory cannot be written", Abort.HARDWARE) from failure


def recall(slave: Slave, memory: Memory, kept: Collection[Address], area: range) -> None:
    """Write the stored values of an area back, as after a reset.

    A value the device does not take, say of another firmware's memory, is reported and left out.
    """
    stored = memory.load(SECTION)
    for address in kept:
        if address[0] in area and (text := stored.get(_key(address))) is not None:
            try:
                slave.write(slave.entry(*address), bytes.fromhex(text))
            except (Rejected, ValueError, TypeError) as refusal:
                log.error("stored value %r of %s is left out: %s", text, _key(address), refusal)


def _key(address: Address) -> str:
    return f"{address[0]:04X}:{address[1]:02X}"


DATE, TIME = 1, 2  # sub-indices of 0x1020


def _is_whole(slave: Slave, index: int, subindex: int) -> bool:
    return slave.has(index, subindex) and slave.entry(index, subindex).is_whole


class ConfigurationCheck(Service):
    """0x1020, where a master writes when it has configured: 0 once something has changed since.

    A process value changes without being configured: what can be mapped does not count.
    """

    any_type = True

    def __init__(self, slave: Slave, kept: Collection[Address]) -> None:
        super().__init__(slave)
        self._signature = [(0x1020, sub) for sub in (DATE, TIME) if _is_whole(slave, 0x1020, sub)]
        self._kept = kept if self._signature else ()
        self._running = False

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Everything that is configured."""
        entries = [self.slave.entry(*address) for address in self._kept]
        return {
            entry.address: Object(write=partial(self._on_write, entry.address))
            for entry in entries
            if entry.address[0] != 0x1020 and entry.size and not entry.variable.pdo_mappable
        }

    def on_state(self, state: State) -> None:
        """What has been stored is in force again: that was no change."""
        self._running = True

    def _on_write(self, address: Address, value: int) -> None:
        entry = self.slave.entry(*address)
        if self._running and value != entry.unpack(entry.read()):
            for each in self._signature:
                signature = self.slave.entry(*each)
                signature.write(signature.pack(0))


class StoredEds(Service):
    """0x1021: the file that describes the device, as it is."""

    any_type = True

    def __init__(self, slave: Slave, eds: str) -> None:
        super().__init__(slave)
        self._eds = eds

    @property
    def objects(self) -> Mapping[Address, Object]:
        """The file; 0x1022 is as it says, and 0 for a file that is not compressed."""
        return {(0x1021, 0): Object(read=self._read)} if self.slave.has(0x1021) else {}

    def _read(self) -> bytes:
        try:
            with od_file(self._eds) as path:
                return path.read_bytes()
        except OSError as failure:
            log.error("%s cannot be read: %s", self._eds, failure)
            raise Rejected("there is no EDS", Abort.NO_DATA) from failure
