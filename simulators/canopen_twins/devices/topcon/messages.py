"""Emergency messages of chapter 8: the errors of the unit by number, those of the card by code."""

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import groupby

from canopen_twins.device import Emcy, EmcyMessage
from canopen_twins.errors import UserError
from canopen_twins.slave.emcy import read_emcy_table

UNIT_ERROR_00 = 0x6100  # with field 0 it is error number 00 of the unit
PROTOCOL_ERROR = 0x8200  # Tab. 82: a parameter exceeds its limit


@cache
def table() -> Mapping[tuple[int, int], Emcy]:
    """Every message by code and error field."""
    return read_emcy_table("topcon_emcy.csv")


@cache
def unit_errors() -> Mapping[int, Emcy]:
    """Those of the unit, by error number."""
    return {
        int.from_bytes(emcy.field, "little"): emcy
        for (code, detail), emcy in table().items()
        if detail or code == UNIT_ERROR_00
    }


@cache
def card_errors() -> Mapping[int, Emcy]:
    """Those of the card, by code: they have no error number (A-63)."""
    return {
        code: emcy
        for (code, detail), emcy in table().items()
        if code and not detail and code != UNIT_ERROR_00
    }


@cache
def messages() -> Mapping[str, EmcyMessage]:
    """Chapter 8 has a table for each code."""
    return {
        f"{code:#06x}": EmcyMessage(_told([emcy.label for emcy in emcies]), code)
        for code, emcies in groupby(table().values(), lambda emcy: emcy.code)
    }


def _told(labels: Sequence[str]) -> str:
    others = len(labels) - 1
    return labels[0] if not others else f"{labels[0]}, and {others} more"


def unit_error(number: int) -> int:
    """An error number of the unit.

    Raises:
        UserError: chapter 8 has none of this number.
    """
    if number not in unit_errors():
        raise UserError(f"no unit error {number:#x}: chapter 8 has 0x00..0x1ff without 0x14d")
    return number


def card_error(code: int) -> int:
    """The code of an error of the card.

    Raises:
        UserError: the card has none of this code.
    """
    if code not in card_errors():
        raise UserError(f"no card error {code:#x}: there is {', '.join(map(hex, card_errors()))}")
    return code
