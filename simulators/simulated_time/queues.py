"""The queues of `queue` in simulated time."""

import queue
from typing import Any

from simulators.simulated_time.in_force import changed, wait


class Queue(queue.Queue[Any]):
    """As `queue.Queue`."""

    def put(self, item: Any, block: bool = True, timeout: float | None = None) -> None:
        """See `queue.Queue`."""
        if block and self.full():
            wait(lambda: not self.full(), timeout)
        super().put(item, block=False)
        changed()

    def get(self, block: bool = True, timeout: float | None = None) -> Any:
        """See `queue.Queue`."""
        if block and self.empty():
            wait(lambda: not self.empty(), timeout)
        item = super().get(block=False)
        changed()
        return item

    def task_done(self) -> None:
        """See `queue.Queue`."""
        super().task_done()
        changed()

    def join(self) -> None:
        """See `queue.Queue`."""
        if self.unfinished_tasks:
            wait(lambda: not self.unfinished_tasks)


class LifoQueue(Queue, queue.LifoQueue[Any]):
    """As `queue.LifoQueue`."""


class PriorityQueue(Queue, queue.PriorityQueue[Any]):
    """As `queue.PriorityQueue`."""


class SimpleQueue(Queue):
    """As `queue.SimpleQueue`, which has no size."""

    def __init__(self) -> None:
        super().__init__()
