"""Errors and the warning: raised by a watch or by hand, kept until a reset without their cause."""

from simulators.devices.topcon.model import error_numbers as number
from simulators.devices.topcon.model.inputs import Inputs
from simulators.devices.topcon.model.plant import Plant
from simulators.devices.topcon.model.protections import WARNINGS, protections, slave_missing
from simulators.devices.topcon.model.watch import Watch


class Latches:
    """`errors` in the order they came, and `warning`."""

    def __init__(self, stage: Inputs, tick: float) -> None:
        count = number.PARALLEL_COUNT if stage.connection == "parallel" else number.SERIES_COUNT
        self._one_short = [count, number.SLAVE_NUMBER]
        self._watch = Watch(protections(stage.unit), tick)
        self._held: list[int] = []
        self.errors: list[int] = []
        self.warning = False

    @property
    def pending(self) -> bool:
        """Whether something may become an error within its delay."""
        return self._watch.pending

    def step(self, plant: Plant) -> None:
        """Latch what has lasted long enough, at the end of a tick."""
        self._watch.step(plant)
        for error in self._watch.errors:
            self.latch(error)
        self.warning = self.warning or _warns(plant)

    def latch(self, error: int) -> None:
        """Note an error, once."""
        known = error == number.SLAVE_SILENT and number.SLAVE_NUMBER in self.errors
        if error not in self.errors and not known:
            self.errors.append(error)

    def hold(self, error: int) -> None:
        """Give an error a cause that lasts until `release`."""
        if error not in self._held:
            self._held.append(error)

    def release(self, error: int) -> None:
        """End a cause given by `hold`."""
        if error in self._held:
            self._held.remove(error)

    def reset(self, plant: Plant) -> None:
        """Forget what has no cause any more (A-49)."""
        left = [error for error in self.errors if self._persists(error, plant)]
        if number.SLAVE_SILENT in left and slave_missing(plant):
            left.remove(number.SLAVE_SILENT)  # the system counts its units anew: one is missing
            left += self._one_short
        self.errors = left
        self.warning = _warns(plant)

    def _persists(self, error: int, plant: Plant) -> bool:
        return (
            error in self._held
            or (error in self._one_short and slave_missing(plant))
            or self._watch.persists(error, plant)
        )


def _warns(plant: Plant) -> bool:
    return any(condition(plant) for condition in WARNINGS)
