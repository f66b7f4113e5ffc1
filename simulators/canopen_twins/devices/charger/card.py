"""The cycle in which the charger sends its actual values (2002h:01h)."""

from collections.abc import Callable, Iterator, Mapping, Sequence

from canopen_twins.bus.clock import Timer
from canopen_twins.devices.charger.settings import Settings
from canopen_twins.errors import UserError
from canopen_twins.slave.object import Abort, Address, Object, Rejected
from canopen_twins.slave.pdo import Rpdo, Tpdo
from canopen_twins.slave.profile import Profile
from canopen_twins.slave.service import Service, State
from canopen_twins.slave.slave import Slave

CYCLE = (0x2002, 0x01)  # ms


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


HEARTBEAT = (0x1017, 0x00)
HEARTBEAT_STEP = 100  # ms, and the shortest time
VERSION_LENGTH = 4  # 100Ah
DISCHARGING_TPDO = 3


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
