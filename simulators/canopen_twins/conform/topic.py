"""Topics of a conformance test: what a slave has to do, where that is written, and how it ends."""

from collections.abc import Callable
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
    """What the table of sections of a device calls it."""
    play: Play


class Group:
    """Topics about one thing, in their order; each is a function, numbered as it stands there."""

    def __init__(self, number: int, title: str, service: str) -> None:
        self.number = number
        self.title = title
        self.topics: list[Topic] = []
        self._service = service

    def topic(self, source: str) -> Callable[[Play], Play]:
        """Let a function be the next topic of the group; its docstring is the title."""

        def add(play: Play) -> Play:
            number = f"{self.number}.{len(self.topics) + 1}"
            title = (play.__doc__ or play.__name__).strip().rstrip(".")
            self.topics.append(Topic(number, title, source, self._service, play))
            return play

        return add
