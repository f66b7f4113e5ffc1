"""The TC.CANOPEN card: its switches (chapter 4) and what its communication leaves of CiA 301."""

from collections.abc import Mapping

from canopen_twins.bus.identifiers import NO_RTR
from canopen_twins.devices.topcon.settings import Settings
from canopen_twins.errors import UserError
from canopen_twins.slave.object import Abort, Rejected
from canopen_twins.slave.profile import Profile

HIGHEST_ID = 127
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
SET_VALUES = ("power_on_voltage", "power_on_current", "power_on_power", "power_on_resistance")


def module_id(settings: Settings) -> int:
    """The node id of the switches AH and AL, or the one set directly (4.2).

    Raises:
        UserError: above 127; what the card does then, the manual does not say (A-04).
    """
    if settings.ah is None and settings.al is None:
        return settings.node_id
    ah, al = settings.ah or 0, settings.al or 0
    value = 16 * ah + al or 1  # 00 is taken as 1
    if value > HIGHEST_ID:
        raise UserError(f"AH={ah} and AL={al} are module id {value}: the highest is {HIGHEST_ID}")
    return value


def bit_rate(switch: int) -> int:
    """The bit rate of switch BR in bit/s (4.3)."""
    return BIT_RATES.get(switch, OTHER_BIT_RATE)


def check_tpdo_cob_id(value: int) -> None:
    """Raises `Rejected` for bit 30, which is always 0 here (7.2.15.1, A-27)."""
    if value & NO_RTR:
        raise Rejected("bit 30 of a TPDO is always 0")


def check(settings: Settings) -> None:
    """Look at what the settings of the card are together.

    Raises:
        UserError: switches that make no module id, texts that no string object can hold, set
            values at power-on that a master could not set.
    """
    module_id(settings)
    for name in ("hardware_version", "firmware"):
        if not getattr(settings, name).isascii():
            raise UserError(f"setting {name!r} is ASCII text: CANopen has no other strings")
    for name in SET_VALUES:
        if getattr(settings, name) > settings.set_value_range:
            raise UserError(f"setting {name!r} is above 'set_value_range'")


def profile(settings: Settings) -> Profile:
    """What the card offers of CiA 301."""
    return Profile(
        first_heartbeat_at_once=settings.hb_first == "now",
        rpdo_types=frozenset({*range(241), 254}),  # Tab. 27
        tpdo_types=frozenset({*range(1, 241), 252, 253}),  # Tab. 36
        no_history_code=Abort.NO_DATA if settings.empty_1003 == "abort" else None,
        strict_cob_id=settings.strict_cobid,
    )
