"""What the bytes of an object mean as a value of a scenario, and the bytes it writes for one."""

from collections.abc import Callable

from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import (
    BOOLEAN,
    FLOAT_TYPES,
    INTEGER_TYPES,
    SIGNED_TYPES,
    VISIBLE_STRING,
)

from canopen_twins.errors import UserError
from canopen_twins.files.document import Item, Scalar
from canopen_twins.scenario.targets import Target

LARGEST = 0xFFFF_FFFF  # of an object that no dictionary knows: four bytes go in one frame


def value_of(target: Target, data: bytes, sized: bool = True) -> object:
    """A number or a text; bytes where they are neither.

    Args:
        target: The object; one that no dictionary knows is a number.
        data: Its bytes.
        sized: Whether all of them count, or as many as the object has.
    """
    variable = target.variable
    if variable is None or variable.data_type is None:
        return int.from_bytes(data, "little")
    codec = ODVariable.STRUCT_TYPES.get(variable.data_type)
    if codec is None:
        return data.decode("ascii", "replace") if target.is_text else data
    if not sized:
        data = data[: codec.size]
    if len(data) == codec.size:
        return codec.unpack(data)[0]
    return int.from_bytes(data, "little") if variable.data_type in INTEGER_TYPES else data


def encode(target: Target, item: Item, limited: bool) -> bytes:
    """A value of the file as it goes to an object; `limited` by access and limits of the EDS.

    Raises:
        UserError: nobody can write it, it is of another type, or out of the limits.
    """
    if (variable := target.variable) is None:
        return item.whole_up_to(LARGEST).to_bytes(4, "little")
    if limited and not variable.writable:
        raise UserError(
            f"{variable.name!r} is read only; if that is the point, put abort: 0x06010002 beside"
        )
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
        value = _in_range(variable, item, limited)
    return _fit(item, lambda: ODVariable.STRUCT_TYPES[data_type].pack(value))


def _in_range(variable: ODVariable, item: Item, limited: bool) -> int:
    bits = len(variable)
    signed = variable.data_type in SIGNED_TYPES
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
    if limited:
        low = low if variable.min is None else max(low, variable.min)
        high = high if variable.max is None else min(high, variable.max)
    if not low <= (value := item.whole) <= high:
        hint = "; if that is the point, put the abort code beside" if limited else ""
        raise item.wrong(f"{item.text} is not in {low}..{high}{hint}")
    return value


def _fit(item: Item, pack: Callable[[], bytes]) -> bytes:
    try:
        return pack()
    except (ValueError, OverflowError):
        raise item.wrong(f"{item.text!r} does not fit this object") from None
