"""Topics of a conformance test: what a slave has to do, where that is written, and how it ends."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

from canopen_twins.conform.tester import Tester

Play = Callable[[Tester], None]
"""Asks the slave; raises `Failed` or `NotApplicable`, and has passed otherwise."""


class Topic(NamedTuple):
    """One thing that is tested."""

    number: str
    """Of its group, and in it: 2.7."""
    title: str
    source: str
    """Where the standard says so."""
    service: str
    """Of its group."""
    play: Play


class Group:
    """Topics about one thing, in their order; several groups with one number are counted on."""

    def __init__(self, number: int, title: str, service: str) -> None:
        """`service` is what the table of sections of a device calls it."""
        self.number = number
        self.title = title
        self.service = service
        self.plays: list[tuple[Play, str]] = []

    def topic(self, source: str) -> Callable[[Play], Play]:
        """Let a function be the next topic of the group; its docstring is the title."""

        def add(play: Play) -> Play:
            self.plays.append((play, source))
            return play

        return add


def numbered(groups: Iterable[Group]) -> Iterator[Topic]:
    """The topics of groups, each with its number."""
    counts: Counter[int] = Counter()
    for group in groups:
        for play, source in group.plays:
            counts[group.number] += 1
            number = f"{group.number}.{counts[group.number]}"
            title = (play.__doc__ or play.__name__).strip().rstrip(".")
            yield Topic(number, title, source, group.service, play)
