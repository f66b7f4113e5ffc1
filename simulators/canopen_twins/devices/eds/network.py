"""Node id of a file's device, if it has one: in force, waiting, and stored (CiA 305)."""

from canopen_twins.bus.identifiers import NODE_IDS, UNCONFIGURED
from canopen_twins.slave.lss import Stored
from canopen_twins.slave.memory import Memory

SECTION = "lss"
ADMISSIBLE = frozenset({*NODE_IDS, UNCONFIGURED})
BIT_TIMINGS = {
    0: 1_000_000,
    1: 800_000,
    2: 500_000,
    3: 250_000,
    4: 125_000,
    6: 50_000,
    7: 20_000,
    8: 10_000,
}
"""By the index of LSS 13h, in bit/s (CiA 305, table 0)."""


class Network:
    """What LSS and resets make of the node id a device is delivered with."""

    def __init__(self, memory: Memory, delivered: int) -> None:
        self._memory = memory
        kept = memory.load(SECTION).get("node_id", delivered)
        self.node_id: int = kept if kept in ADMISSIBLE else delivered
        self.pending = self.node_id
        self.bit_timing = self._pending_timing = memory.load(SECTION).get("bit_timing")

    def reset(self) -> None:
        """What waits comes into force."""
        self.node_id = self.pending

    def configure_node_id(self, node_id: int) -> bool:
        """LSS 11h."""
        if node_id in ADMISSIBLE:
            self.pending = node_id
        return node_id in ADMISSIBLE

    def configure_bit_timing(self, table: int, index: int) -> bool:
        """LSS 13h."""
        accepted = table == 0 and index in BIT_TIMINGS
        if accepted:
            self._pending_timing = index
        return accepted

    def activate_bit_timing(self) -> None:
        """LSS 15h."""
        self.bit_timing = self._pending_timing

    def store(self) -> Stored:
        """LSS 17h."""
        kept = {"node_id": self.pending, "bit_timing": self._pending_timing}
        try:
            self._memory.store(SECTION, kept)
        except OSError:
            return Stored.FAILED
        return Stored.DONE
