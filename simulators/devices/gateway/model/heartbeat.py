"""Heartbeats of the partner, as the gateway watches them: counted in main cycles (6)."""

from dataclasses import dataclass

from simulators.devices.gateway.model.state import State


@dataclass
class Consumer:
    """Watches the partner in Operational."""

    limit: int
    """Main cycles after which the partner is missed; 0: it is not watched (428, 430)."""
    always_armed: bool = False
    """Whether it is missed even before its first heartbeat in Operational (A-19)."""
    tripped: bool = False
    _armed: bool = False
    _age: int = 0

    def begin(self) -> None:
        """Operational was entered."""
        self.tripped, self._armed, self._age = False, self.always_armed, 0

    def receive(self) -> None:
        """A heartbeat came; a trip is over."""
        self.tripped, self._armed, self._age = False, True, 0

    def step(self, state: State) -> None:
        """One main cycle without a heartbeat."""
        if state is State.OPERATIONAL and self._armed:
            self._age += 1
            self.tripped = self.tripped or 0 < self.limit < self._age
