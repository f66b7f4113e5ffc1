"""The charger on its bus: profile, heartbeat, the cycle of its TPDOs, node id and bit timing."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

from canopen_twins.bus.clock import Timer
from canopen_twins.bus.identifiers import NODE_IDS
from canopen_twins.device import (
    Abort,
    Address,
    Object,
    Profile,
    Rejected,
    Rpdo,
    Service,
    Slave,
    State,
    Tpdo,
)
from canopen_twins.devices.charger.settings import Settings
from canopen_twins.errors import UserError
from canopen_twins.slave.lss import Stored

HEARTBEAT = (0x1017, 0x00)
HEARTBEAT_STEP = 100  # ms, and the shortest time
VERSION_LENGTH = 4  # 100Ah
DISCHARGING_TPDO = 3
CYCLE = (0x2002, 0x01)  # ms
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


def check(settings: Settings) -> None:
    """Look at what the manual says of the length of texts and the steps of times.

    Raises:
        UserError: something else.
    """
    if len(settings.firmware) != VERSION_LENGTH or not settings.firmware.isascii():
        raise UserError(f"setting 'firmware' is {settings.firmware!r}: four ASCII characters")
    try:
        heartbeat_time(settings.heartbeat_default_ms)
    except Rejected as refusal:
        raise UserError(f"setting 'heartbeat_default_ms': {refusal}") from refusal


def profile(settings: Settings) -> Profile:
    """What the charger offers of CiA 301."""
    return Profile(
        segmented=False,
        nmt_lengths=range(2, 9),
        tpdo_on_change=settings.tpdo_on_change,
        store_signature=settings.signature == "cia301",
        restore_at_once=True,
        rpdo_emcy=False,
    )


def objects(settings: Settings) -> Mapping[Address, Object]:
    """What a single charger is told by, and its heartbeat."""
    times = heartbeat_time if settings.heartbeat_step == "reject" else floored_heartbeat_time
    return {
        HEARTBEAT: Object(adjust=times),
        (0x100A, 0): Object(read=lambda: settings.firmware),
        (0x1018, 2): Object(read=lambda: settings.product_code),
        (0x1018, 3): Object(read=lambda: settings.revision),
        (0x1018, 4): Object(read=lambda: settings.serial),
    }


def pdos(slave: Slave, tell: Callable[[int, Rejected], None], *, silent: bool) -> Iterator[Service]:
    """One to receive, three to send in one cycle; `silent`: two, without the discharging."""
    numbers = [n for n in Tpdo.numbers(slave) if not (silent and n == DISCHARGING_TPDO)]
    tpdos = [Tpdo(slave, number) for number in numbers]
    yield from (Rpdo(slave, number, tell) for number in Rpdo.numbers(slave))
    yield from tpdos
    yield ActualValueTransfer(slave, tpdos)


def heartbeat_time(milliseconds: int) -> int:
    """What 1017h takes: 0, or steps of 100 ms (A-02).

    Raises:
        Rejected: something else.
    """
    if 0 < milliseconds < HEARTBEAT_STEP:
        raise Rejected(f"{milliseconds} ms is below {HEARTBEAT_STEP}", Abort.TOO_LOW)
    if milliseconds % HEARTBEAT_STEP:
        raise Rejected(f"{milliseconds} ms is no multiple of {HEARTBEAT_STEP}")
    return milliseconds


def floored_heartbeat_time(milliseconds: int) -> int:
    """The same for a charger that cuts what is beyond a step; too short is too short."""
    if milliseconds < HEARTBEAT_STEP:
        return heartbeat_time(milliseconds)
    return milliseconds - milliseconds % HEARTBEAT_STEP


class ActualValueTransfer(Service):
    """Sends every TPDO once a cycle; the first set they send themselves in Operational (A-24)."""

    def __init__(self, slave: Slave, tpdos: Sequence[Tpdo]) -> None:
        super().__init__(slave)
        self._tpdos = tpdos
        self._operational = False
        self._timer: Timer | None = None

    @property
    def objects(self) -> Mapping[Address, Object]:
        """A new cycle begins with the write."""
        return {CYCLE: Object(write=self._start)}

    def on_state(self, state: State) -> None:
        """PDOs are for Operational only."""
        self._operational = state is State.OPERATIONAL
        self._start(self.slave.number(*CYCLE))

    def _start(self, milliseconds: int) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = None
        if self._operational:
            self._timer = self.slave.clock.every(milliseconds / 1000, self._send)

    def _send(self) -> None:
        for tpdo in self._tpdos:
            tpdo.transmit()


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
