"""Emergency messages of chapter 8: the errors of the unit by number, those of the card by code."""

from collections.abc import Mapping, Sequence
from itertools import groupby

from canopen_twins.device.device import EmcyMessage
from canopen_twins.errors import UserError
from canopen_twins.slave.emcy import Emcy, read_emcy_table

TABLE = read_emcy_table("topcon_emcy.csv")


def _told(labels: Sequence[str]) -> str:
    others = len(labels) - 1
    return labels[0] if not others else f"{labels[0]}, and {others} more"


UNIT: Mapping[int, Emcy] = {
    int.from_bytes(emcy.field, "little"): emcy
    for (code, detail), emcy in TABLE.items()
    if detail or code == 0x6100  # 6100h with field 0 is error number 00 of the unit
}
CARD: Mapping[int, Emcy] = {
    code: emcy
    for (code, detail), emcy in TABLE.items()
    if code and not detail and code != 0x6100  # they have no error number
}
KINDS: Mapping[str, EmcyMessage] = {  # chapter 8: a table for each code
    f"{code:#06x}": EmcyMessage(_told([emcy.label for emcy in emcies]), code)
    for code, emcies in groupby(TABLE.values(), lambda emcy: emcy.code)
}
PROTOCOL_ERROR = CARD[0x8200]  # Tab. 82: a parameter exceeds its limit


def unit_error(number: int) -> int:
    """An error number of the unit.

    Raises:
        UserError: chapter 8 has none of this number.
    """
    if number not in UNIT:
        raise UserError(f"no unit error {number:#x}: chapter 8 has 0x00..0x1ff without 0x14d")
    return number


def card_error(code: int) -> int:
    """The code of an error of the card.

    Raises:
        UserError: the card has none of this code.
    """
    if code not in CARD:
        raise UserError(f"no card error {code:#x}: there is {', '.join(map(hex, CARD))}")
    return code


class CardErrors:
    """Errors of the card: told and kept until the reset, the unit goes on (A-63)."""

    def __init__(self) -> None:
        self.active: tuple[Emcy, ...] = ()

    def add(self, code: int) -> None:
        """Raise one; without effect while it is active."""
        if CARD[code] not in self.active:
            self.active = (*self.active, CARD[code])

    def reset(self) -> None:
        """Command 2 of 0x2014."""
        self.active = ()
