"""What other threads want of the twins, carried out by the twins' own between two frames."""

from collections import deque
from collections.abc import Callable, Generator
from concurrent.futures import Future
from typing import Any, TypeVar

Answer = TypeVar("Answer")

Portions = Generator[None, None, Answer]
"""Something long, cut where a frame may be answered in between; each portion is below 0.5 ms."""


class Orders:
    """Any thread puts, in the order in which it is to be done; only that of the twins carries out.

    What an action raises is raised to whoever waits for its answer.
    """

    def __init__(self) -> None:
        self._queue: deque[tuple[Portions[Any], Future[Any]]] = deque()

    @property
    def waiting(self) -> bool:
        """Whether there is something to be done."""
        return bool(self._queue)

    def put(self, action: Callable[[], Answer]) -> "Future[Answer]":
        """Have something short done."""
        return self.put_portions(_at_once(action))

    def put_portions(self, portions: Portions[Answer]) -> "Future[Answer]":
        """Have something done that takes its time; other orders wait until it is over."""
        future: Future[Answer] = Future()
        self._queue.append((portions, future))
        return future

    def carry_out(self) -> None:
        """The next portion of the first order; whoever waits no more is passed over."""
        portions, future = self._queue[0]
        if not (future.running() or future.set_running_or_notify_cancel()):
            self._queue.popleft()
            return
        try:
            next(portions)
        except StopIteration as end:
            self._queue.popleft()
            future.set_result(end.value)
        except Exception as refusal:  # a bug is one of who asked, too: it is raised there
            self._queue.popleft()
            future.set_exception(refusal)

    def close(self) -> None:
        """Nobody carries out any more: whoever waits is told so by a cancelled future."""
        while self._queue:
            self._queue.popleft()[1].cancel()


def _at_once(action: Callable[[], Answer]) -> Portions[Answer]:
    yield from ()
    return action()
