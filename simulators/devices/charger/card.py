"""How the charger shows itself on the bus: identity, PDOs, and what it leaves of CiA 301."""

from collections.abc import Callable, Iterator, Mapping

from simulators.devices.charger.settings import Settings
from simulators.devices.charger.transfer import ActualValueTransfer
from simulators.errors import UserError
from simulators.objects import Abort, Address, Object, Rejected
from simulators.profile import Profile
from simulators.services import Service
from simulators.services.rpdo import Rpdo
from simulators.services.tpdo import Tpdo
from simulators.slave import Slave

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
