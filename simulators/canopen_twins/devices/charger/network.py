"""Node id and bit timing: in force, waiting for a reset, and as a parameter (A-34)."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from canopen_twins.bus.identifiers import NODE_IDS
from canopen_twins.slave.lss import Stored
from canopen_twins.slave.object import Address, Object, Rejected

BIT_RATES: Mapping[int, int] = {
    0: 1_000_000,
    1: 800_000,
    2: 500_000,
    3: 250_000,
    4: 125_000,
    6: 50_000,
    7: 25_000,
    8: 10_000,
}
"""0x2002:07, in bit/s; there is no 5, and 7 is not that of CiA 305 (A-15)."""
STANDARD_TABLE = 0  # the only table selector of LSS


class Place(NamedTuple):
    """Where a node is to be found on which bus."""

    node_id: int
    bit_timing: int


def fits(node_id: int, bit_timing: int) -> bool:
    """Whether the charger can have both."""
    return node_id in NODE_IDS and bit_timing in BIT_RATES


class Network:
    """What 0x2002:06 and 07, LSS and resets make of a stored place.

    LSS sets `pending` and stores it; a write sets `parameter`, which 0x1010 stores and lets wait.
    A reset of the communication takes over what waits, a reset of the node what is stored.
    """

    def __init__(self, stored: Place, keep: Callable[[Place], None]) -> None:
        self.active = self.pending = self.parameter = stored
        self._keep = keep

    @property
    def bit_rate(self) -> int:
        """In force, in bit/s."""
        return BIT_RATES[self.active.bit_timing]

    @property
    def objects(self) -> Mapping[Address, Object]:
        """The parameter; what is written acts after it is saved and the node is reset."""
        return {
            (0x2002, 0x06): Object(
                lambda: self.parameter.node_id, self._set_node_id, obstacle=self._obstacle
            ),
            (0x2002, 0x07): Object(
                lambda: self.parameter.bit_timing, self._set_bit_timing, obstacle=self._obstacle
            ),
        }

    def configure_node_id(self, node_id: int) -> bool:
        """LSS 11h; 255, which would be none, is refused (A-39)."""
        if node_id in NODE_IDS:
            self.pending = self.pending._replace(node_id=node_id)
        return node_id in NODE_IDS

    def configure_bit_timing(self, table: int, index: int) -> bool:
        """LSS 13h."""
        accepted = table == STANDARD_TABLE and index in BIT_RATES
        if accepted:
            self.pending = self.pending._replace(bit_timing=index)
        return accepted

    def activate_bit_timing(self) -> None:
        """LSS 15h."""
        self.active = self.active._replace(bit_timing=self.pending.bit_timing)

    def store(self) -> Stored:
        """LSS 17h."""
        try:
            self._keep(self.pending)
        except OSError:
            return Stored.FAILED
        self.parameter = self.pending
        return Stored.DONE

    def save(self) -> None:
        """0x1010.

        Raises:
            OSError: the memory cannot be written.
        """
        self._keep(self.parameter)
        self.pending = self.parameter

    def reset_communication(self) -> None:
        """NMT 82h: what waits comes into force (CiA 305)."""
        self.active = self.pending

    def _obstacle(self, value: int) -> str:
        waits = self.parameter != self.active
        return "it acts after it is saved by 0x1010 and the node is reset" if waits else ""

    def _set_node_id(self, node_id: int) -> None:
        self.parameter = self.parameter._replace(node_id=node_id)

    def _set_bit_timing(self, index: int) -> None:
        if index not in BIT_RATES:
            raise Rejected(f"no bit timing {index}")
        self.parameter = self.parameter._replace(bit_timing=index)
