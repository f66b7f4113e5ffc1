"""When the master of a run begins, when the run is over, and what its verdict says of that."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from canopen_twins.live.master_process import MasterProcess
from canopen_twins.live.node_id_watch import NodeIdWatch
from canopen_twins.live.parent import Parent

if TYPE_CHECKING:
    from canopen_twins.scenario import Player


class RunEnd:
    """Asked by `serve` again and again whether all is over.

    A master that still runs by then is told to end, and served until it has.

    Args:
        signalled: Whether somebody has told us to end.
        player: Of the scenario, if there is one.
        master: The command beside it, if there is one.
        parent: At whose end we end, if there is one.
        doubles: Nodes with our node ids that end the run, if they do.
    """

    def __init__(
        self,
        signalled: Callable[[], bool],
        player: Player | None = None,
        master: MasterProcess | None = None,
        parent: Parent | None = None,
        doubles: NodeIdWatch | None = None,
    ) -> None:
        self._signalled = signalled
        self._player = player
        self._master = master
        self._parent = parent
        self._doubles = doubles
        self._heeded = False  # that the master has ended
        self._over = False

    def begin(self) -> None:
        """The twins are on the bus: start the master."""
        if self._master is not None:
            self._master.start()

    def __call__(self) -> bool:
        """Whether the run is over."""
        if not self._over:
            self._over = self._is_over()
        if not self._over or self._master is None:
            return self._over
        self._master.ask_to_end()
        return self._master.gone

    def _is_over(self) -> bool:
        if self._signalled() or (self._parent is not None and self._parent.gone):
            return True
        if self._doubles is not None and self._doubles.found:
            return True
        ended = self._master is not None and self._master.code is not None
        if ended and self._player is None:
            return True
        if ended and not self._heeded:
            self._heed()
        return self._player is not None and self._player.done

    def _heed(self) -> None:
        """The master has ended by itself."""
        self._heeded = True
        assert self._master is not None
        assert self._player is not None
        if self._master.failure:
            self._player.abort(f"the command {self._master}", self._master.failure)
        elif self._player.scenario.ends_with_command:
            self._player.conclude()
