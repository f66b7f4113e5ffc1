"""The bytes a scenario writes: values of the type and within the limits of their object."""

from collections.abc import Callable

from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import (
    BOOLEAN,
    FLOAT_TYPES,
    SIGNED_TYPES,
    VISIBLE_STRING,
)

from canopen_twins.errors import UserError
from canopen_twins.files.document import Item
from canopen_twins.files.yaml_nodes import Scalar


def encode(variable: ODVariable, item: Item, limited: bool) -> bytes:
    """A value of the file as it goes to an object; `limited` also by the limits of the EDS.

    Raises:
        UserError: it is of another type, or out of the limits.
    """
    data_type = variable.data_type or 0
    if data_type == VISIBLE_STRING:
        return _fit(item, lambda: item.text.encode("ascii"))
    if data_type not in ODVariable.STRUCT_TYPES:
        raise UserError(f"objects of data type {data_type:#06x} cannot be written here")
    if data_type == BOOLEAN:
        value: Scalar = item.one_of("truth value", ("true", "false")) == "true"
    elif data_type in FLOAT_TYPES:
        value = item.number
    else:
        value = item.whole
        _check_range(variable, item, limited)
    return _fit(item, lambda: ODVariable.STRUCT_TYPES[data_type].pack(value))


def check_readable(variable: ODVariable) -> None:
    """Raises `UserError` if the EDS lets nobody read an object."""
    if not variable.readable:
        raise UserError(
            f"{variable.name!r} is write only; if that is the point, put abort: 0x06010001 beside"
        )


def check_writable(variable: ODVariable) -> None:
    """Raises `UserError` if the EDS lets nobody write an object."""
    if not variable.writable:
        raise UserError(
            f"{variable.name!r} is read only; if that is the point, put abort: 0x06010002 beside"
        )


def _check_range(variable: ODVariable, item: Item, limited: bool) -> None:
    bits = len(variable)
    signed = variable.data_type in SIGNED_TYPES
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
    if limited:
        low = low if variable.min is None else max(low, variable.min)
        high = high if variable.max is None else min(high, variable.max)
    if not low <= item.whole <= high:
        hint = "; if that is the point, put the abort code beside" if limited else ""
        raise item.wrong(f"{item.text} is not in {low}..{high}{hint}")


def _fit(item: Item, pack: Callable[[], bytes]) -> bytes:
    try:
        return pack()
    except (ValueError, OverflowError):
        raise item.wrong(f"{item.text!r} does not fit this object") from None
