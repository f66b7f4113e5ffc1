"""Where two sequences begin to differ: read side by side, with little of them in memory."""

from collections import deque
from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Generic, NamedTuple, TypeVar

BEFORE, AHEAD = 5, 50  # kept before the difference, and read on behind it

Item = TypeVar("Item")


class Difference(NamedTuple, Generic[Item]):
    """The first difference, and what is around it."""

    common: int
    """How many are the same on both sides."""
    before: tuple[Item, ...]
    """The last of these."""
    left: tuple[Item, ...]
    """What comes next on the one side; nothing if it has ended."""
    right: tuple[Item, ...]
    """The same for the other."""

    def __bool__(self) -> bool:
        """Whether there is one."""
        return bool(self.left or self.right)


def compare(left: Iterable[Item], right: Iterable[Item]) -> Difference[Item]:
    """Read both as far as they are the same."""
    ours, theirs = iter(left), iter(right)
    before: deque[Item] = deque(maxlen=BEFORE)
    common = 0
    for one, other in _pairs(ours, theirs):
        if one != other:
            return Difference(common, tuple(before), _ahead(one, ours), _ahead(other, theirs))
        before.extend(one)
        common += 1
    return Difference(common, tuple(before), (), ())


def _pairs(
    left: Iterator[Item], right: Iterator[Item]
) -> Iterator[tuple[tuple[Item, ...], tuple[Item, ...]]]:
    """One of each, in tuples that are empty where a side has ended."""
    while True:
        pair = tuple(islice(left, 1)), tuple(islice(right, 1))
        if not any(pair):
            return
        yield pair


def _ahead(first: tuple[Item, ...], rest: Iterator[Item]) -> tuple[Item, ...]:
    return (*first, *islice(rest, AHEAD))
