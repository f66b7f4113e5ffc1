"""Parameter values of one control unit: as edited, as saved, and as its programme has them."""

from collections.abc import Mapping
from copy import copy

from canopen_twins.devices.gateway.model.parameters import Parameter


class Store:
    """A changed value acts after it was saved and the unit was reset; otherwise it is lost (7)."""

    def __init__(self, parameters: Mapping[int, Parameter]) -> None:
        self._defaults = {n: each.default for n, each in parameters.items() if each.writable}
        self._edited: dict[int, float] = {}
        self._effective = dict(self._defaults)
        self.saved: dict[int, float] = {}
        """What is kept without power, where it differs from the default."""

    def edit(self, number: int, value: float) -> None:
        """Change a value in the working memory."""
        self._edited[number] = value

    def shown(self, number: int) -> float:
        """The value DcDesk shows: the edited one."""
        return self._edited.get(number, self.saved.get(number, self._defaults[number]))

    def save(self) -> None:
        """Keep what was edited."""
        values = self.saved | self._edited
        self.saved = {n: values[n] for n in sorted(values) if values[n] != self._defaults[n]}

    def load(self, *, damaged: bool = False) -> None:
        """Begin with what was saved; with the defaults if that is damaged (3099 bit 5)."""
        self._edited = {}
        self._effective = self._defaults if damaged else self._defaults | self.saved

    @property
    def after_reset(self) -> "Store":
        """As the next start finds it, if nothing is damaged."""
        store = copy(self)
        store.load()
        return store

    def __getitem__(self, number: int) -> int:
        """The value in force of a parameter without decimals."""
        return int(self._effective[number])

    def effective(self, number: int) -> float:
        """The value in force, in the unit of its parameter."""
        return self._effective[number]
