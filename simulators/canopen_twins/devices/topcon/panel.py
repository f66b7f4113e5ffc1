"""Who is in control, the panel (HMI or RCU, chapter 6) or the bus; and RS-232 (chapter 5)."""

import logging
from collections.abc import Callable

from canopen_twins.device import Abort, Rejected, State

log = logging.getLogger(__name__)


class Panel:
    """The panel may go local while the node is not operational; Operational takes control back."""

    def __init__(self, quiet_time: float, refuses: bool) -> None:
        self.local = False  # 6: remote after power-on
        self._refuses = refuses
        self._state = State.INITIALISING
        self._quiet_time = quiet_time
        self.quiet: Callable[[], float] = float
        """Seconds since the last frame for this node or from it."""

    @property
    def may_go_local(self) -> bool:
        """Whether the panel can take control (6)."""
        return self._state in (State.PRE_OPERATIONAL, State.STOPPED)

    @property
    def rs232_available(self) -> bool:
        """Whether the card's RS-232 port answers: not without Pre-operational, not beside CAN."""
        return self._state is State.PRE_OPERATIONAL and self.quiet() >= self._quiet_time

    @property
    def obstacle(self) -> str:
        """Why a setting from the bus does not act at this moment; empty if it does (6)."""
        return "the panel is in control (manual 6)" if self.local else ""

    def want(self, local: bool) -> None:
        """The operator turns the key; without effect where the panel cannot go local."""
        self.local = local and self.may_go_local

    def yields(self, what: str) -> bool:
        """Whether a setting from the bus acts: while the panel is local it does not (6, A-08).

        Raises:
            Rejected: the settings want it refused, not ignored.
        """
        if not self.local:
            return True
        if self._refuses:
            raise Rejected("the panel is in control", Abort.LOCAL_CONTROL)
        log.warning("%s is ignored: the panel is in control", what)
        return False

    def on_state(self, state: State) -> None:
        """Operational means remote control."""
        self._state = state
        if state is State.OPERATIONAL:
            self.local = False
