"""The process at whose end another one has to end, too."""

import os
import select

from canopen_twins.errors import UserError


class Parent:
    """A process by its id; `gone` is asked again and again and costs a few microseconds.

    Where there are file descriptors of processes (Linux 5.3) another process that gets the same id
    later is not taken for it.
    """

    def __init__(self, process_id: int) -> None:
        """Raises `UserError` if there is no such process."""
        self._id = process_id
        self._poll: select.poll | None = None
        try:
            if hasattr(os, "pidfd_open"):
                self._descriptor = os.pidfd_open(process_id)
                self._poll = select.poll()
                self._poll.register(self._descriptor, select.POLLIN)
            elif not self._lives():
                raise ProcessLookupError
        except (OSError, OverflowError) as failure:
            raise UserError(f"--parent {process_id}: there is no such process") from failure

    @property
    def gone(self) -> bool:
        """Whether it has ended."""
        return bool(self._poll.poll(0)) if self._poll is not None else not self._lives()

    def _lives(self) -> bool:
        if os.getppid() == self._id:
            return True
        try:
            os.kill(self._id, 0)
        except ProcessLookupError:
            return False
        except PermissionError:
            return True
        return True
