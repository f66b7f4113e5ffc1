"""The TC.CANOPEN card: switches (chapter 4), what it leaves of CiA 301, registers, own errors."""

import re
from collections.abc import Mapping

from canopen_twins.bus.identifiers import NO_RTR
from canopen_twins.device import Abort, Address, Emcy, Object, Profile, Rejected
from canopen_twins.devices.topcon.messages import card_errors
from canopen_twins.devices.topcon.panel import Panel
from canopen_twins.devices.topcon.settings import Settings
from canopen_twins.errors import UserError

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
WIDE_FROM = [4, 20]  # firmware from which register addresses have 24 bits
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
        rpdo_emcy=False,
    )


class Registers:
    """The card's window on a sparse store of 16-bit registers; unwritten ones read 0 (A-56)."""

    def __init__(self, firmware: str, values: dict[int, int], panel: Panel) -> None:
        version = [int(number) for number in re.findall(r"\d+", firmware)]
        self.address_bits = 24 if version >= WIDE_FROM else 16
        self.address = 0
        self._values = values
        self._panel = panel

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Address and value."""
        return {
            (0x2100, 1): Object(read=lambda: self.address, write=self._select),
            (0x2100, 2): Object(read=lambda: self._values.get(self.address, 0), write=self._write),
        }

    def _select(self, address: int) -> None:
        if address >> self.address_bits:
            reason = f"this firmware has addresses of {self.address_bits} bits"
            raise Rejected(reason, Abort.TOO_HIGH)
        self.address = address

    def _write(self, value: int) -> None:
        if self._panel.yields(f"register {self.address:#x}"):
            self._values[self.address] = value


class CardErrors:
    """Errors of the card: told and kept until the reset, the unit goes on (A-63)."""

    def __init__(self) -> None:
        self.active: tuple[Emcy, ...] = ()

    def add(self, code: int) -> None:
        """Raise one; without effect while it is active."""
        error = card_errors()[code]
        if error not in self.active:
            self.active = (*self.active, error)

    def reset(self) -> None:
        """Command 2 of 0x2014."""
        self.active = ()
