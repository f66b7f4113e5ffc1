"""The gateway's side of the handshake: collects the init telegrams of a session and judges them."""

from simulators.devices.gateway.model.dictionary import Dictionary, built, refusal
from simulators.devices.gateway.model.store import Store
from simulators.devices.gateway.model.telegrams import InitData, InitPart, Refusal


class Initialisation:
    """What is of another session than the current one is ignored by whoever calls."""

    def __init__(self, settings: Store) -> None:
        self._settings = settings
        self._parts: list[InitPart] = []
        self.session = 0
        """Of the governor's last Init; 0 before the first."""
        self.fresh = True
        """No initialisation has succeeded since the reset."""

    def begin(self, session: int) -> None:
        """The governor has ordered Init."""
        self.session, self._parts = session, []

    def collect(self, data: InitData) -> None:
        """One piece of the configuration."""
        self._parts.append(data.part)

    def judge(self, count: int) -> Dictionary | Refusal:
        """The dictionary, or what is wrong with structure or content (7.3)."""
        if count != len(self._parts):
            return Refusal.STRUCTURE
        dictionary = built(self._parts, self._settings)
        return refusal(dictionary, self._settings) or dictionary
