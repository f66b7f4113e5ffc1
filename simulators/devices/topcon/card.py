"""The TC.CANOPEN card: its switches (chapter 4) and what its communication leaves of CiA 301."""

from collections.abc import Mapping

from simulators.devices.topcon.settings import Settings
from simulators.errors import UserError
from simulators.objects import Abort, Rejected
from simulators.profile import Profile
from simulators.services.cob_id import NO_RTR

SWITCH = range(16)
BIT_RATES: Mapping[int, int] = {
    1: 10_000,
    2: 20_000,
    3: 50_000,
    4: 125_000,
    5: 250_000,
    6: 500_000,
    7: 800_000,
}
"""Tab. 8, in bit/s."""
OTHER_BIT_RATE = 250_000


def module_id(settings: Settings) -> int:
    """The node id of the switches AH and AL, or the one set directly (4.2).

    Raises:
        UserError: a switch out of its range.
    """
    if settings.ah is None and settings.al is None:
        return settings.node_id
    ah, al = settings.ah or 0, settings.al or 0
    if ah not in SWITCH or al not in SWITCH:
        raise UserError(f"switches have positions 0..15, not AH={ah}, AL={al}")
    return 16 * ah + al or 1  # 00 is taken as 1


def bit_rate(switch: int) -> int:
    """The bit rate of switch BR in bit/s (4.3)."""
    return BIT_RATES.get(switch, OTHER_BIT_RATE)


def check_tpdo_cob_id(value: int) -> None:
    """Raises `Rejected` for bit 30, which is always 0 here (7.2.15.1, A-27)."""
    if value & NO_RTR:
        raise Rejected("bit 30 of a TPDO is always 0")


def profile(settings: Settings) -> Profile:
    """What the card offers of CiA 301."""
    return Profile(
        too_long=Abort.LENGTH,
        too_short=Abort.LENGTH,
        first_heartbeat_at_once=settings.hb_first == "now",
        rpdo_types=frozenset({*range(241), 254}),  # Tab. 27
        tpdo_types=frozenset({*range(1, 241), 252, 253}),  # Tab. 36
        no_history_code=Abort.NO_DATA if settings.empty_1003 == "abort" else None,
        strict_cob_id=settings.strict_cobid,
    )
