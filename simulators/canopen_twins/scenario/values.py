"""What bytes on the bus mean as the value of an object."""

from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import INTEGER_TYPES

from canopen_twins.scenario.targets import Target


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
