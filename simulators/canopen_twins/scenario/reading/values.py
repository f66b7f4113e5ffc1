"""Which values of objects are meant."""

from collections.abc import Callable, Mapping
from math import inf

from canopen_twins.files.document import Item
from canopen_twins.scenario.schema import Wanted as Limits
from canopen_twins.scenario.targets import Target
from canopen_twins.scenario.values import Anything, Range, Text, Wanted
from canopen_twins.scenario.words import ANY

Told = Mapping[Item, Item | Limits]


def wanted(told: Told, find: Callable[[Item], Target]) -> tuple[tuple[Target, Wanted], ...]:
    """Objects with what they should have; notes as a problem what cannot be."""
    found = []
    for key, value in told.items():
        with key.problems.at(key):
            target = find(key)
            found.append((target, _meant(target, value)))
    return tuple(found)


def _meant(target: Target, value: Item | Limits) -> Wanted:
    if isinstance(value, Limits):
        return _range(target, value)
    if value.text == ANY:
        return Anything()
    if target.is_text:
        return Text(value.text)
    return Range(value.number, value.number, _is_hexadecimal(value))


def _range(target: Target, told: Limits) -> Range:
    if target.is_text:
        raise told.place.wrong("one value is wanted here, not several")
    given = [each for each in (told.exactly, told.tolerance, told.low, told.high) if each]
    low, high = _ends(told)
    if low > high:
        raise told.place.wrong(f"no value is in {low}..{high}")
    return Range(low, high, any(map(_is_hexadecimal, given)))


def _ends(told: Limits) -> tuple[float, float]:
    if told.exactly is not None:
        width = 0 if told.tolerance is None else told.tolerance.number
        return told.exactly.number - width, told.exactly.number + width
    low = -inf if told.low is None else told.low.number
    return low, inf if told.high is None else told.high.number


def _is_hexadecimal(item: Item) -> bool:
    return item.text.startswith("0x")
