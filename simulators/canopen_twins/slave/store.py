"""Store and restore parameters, 0x1010 and 0x1011, with their signatures (CiA 301, 7.5.2.13)."""

import logging
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from math import inf
from typing import Protocol

from canopen_twins.slave.memory import Memory
from canopen_twins.slave.object import Abort, Address, Object, Rejected
from canopen_twins.slave.service import Service
from canopen_twins.slave.slave import Slave

log = logging.getLogger(__name__)

SAVE = int.from_bytes(b"save", "little")
LOAD = int.from_bytes(b"load", "little")
ON_COMMAND = 1  # what reading says: stored when told to, not by itself
SECTION = "parameters"


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
        commands: dict[Address, Callable[[int], None]] = {
            (0x1010, 1): self._save,
            (0x1011, 1): self._restore,
        }
        return {
            address: Object(read=lambda: ON_COMMAND, write=command)
            for address, command in commands.items()
            if self.slave.has(*address)
        }

    def _save(self, signature: int) -> None:
        self._check(signature, SAVE)
        data = {_key(address): self.slave.entry(*address).read().hex() for address in self._kept}
        with _writing():
            self._memory.store(SECTION, data)
            self._keeper.save()
        self._free = self.slave.clock.now + self._busy_time

    def _restore(self, signature: int) -> None:
        self._check(signature, LOAD)
        with _writing():
            self._memory.store(SECTION, {})
            self._keeper.restore()
        self._free = self.slave.clock.now + self._busy_time
        if self.slave.profile.restore_at_once:
            for entry in (self.slave.entry(*address) for address in self._kept):
                self.slave.write(entry, entry.initial)

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
