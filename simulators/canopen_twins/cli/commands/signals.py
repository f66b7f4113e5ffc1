"""SIGINT and SIGTERM as wishes: what is under way is finished first."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from canopen_twins.cli.exit_codes import INTERRUPTED, OK


class Wishes(list[int]):
    """The signals that have come."""

    @property
    def code(self) -> int:
        """The exit code of a command that ends because of them."""
        return INTERRUPTED if signal.SIGINT in self else OK


@contextmanager
def signals() -> Iterator[Wishes]:
    """Take them, and give them back at the end."""
    caught = Wishes()

    def catch(number: int, frame: FrameType | None) -> None:
        caught.append(number)

    before = {number: signal.signal(number, catch) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield caught
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
