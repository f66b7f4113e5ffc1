"""The POWER CHARGER: what masters, operators, surroundings and scenarios do to it."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from enum import Enum, auto
from typing import Any

from canopen_twins.devices.charger.model.machine import Machine
from canopen_twins.devices.charger.model.messages import COUNTER, Catalogue, Kind, Message
from canopen_twins.devices.charger.model.parameters import Parameter, Parameters
from canopen_twins.devices.charger.model.release import Source
from canopen_twins.devices.charger.model.sparks import Sparks
from canopen_twins.devices.charger.model.types import Build, Variant

# /C has no entries for the settings of its discharging: by the letter it just works.
FIXED_IN_C = {
    Parameter.MODE_DISCHARGING: 1,
    Parameter.SOFTWARE_RELEASE_DISCHARGING: 0,
    Parameter.POLLUTION_DETECTION_DISCHARGING: 1,
}


class Key(Enum):
    """The keys of the keypad that matter here."""

    ON = auto()
    OFF = auto()


class Charger(Machine):
    """Time passes in `step`; the rest are commands, and what shows how things are.

    Args:
        build: Type and variant.
        values: Every parameter, as stored or as the factory sets it.
        catalogue: The messages that can be reported.
        sparks: The detector, where another reading of the manual is wanted (A-56, A-57).
    """

    def __init__(
        self,
        build: Build,
        values: Mapping[Parameter, int],
        catalogue: Catalogue,
        sparks: Sparks | None = None,
    ) -> None:
        parameters = Parameters(build.kind, values)
        super().__init__(build, parameters, catalogue, sparks or Sparks())
        self._fixed = FIXED_IN_C if build.entries_of is Variant.C else {}
        self.restart(values)

    def restart(self, values: Mapping[Parameter, int]) -> None:
        """As after switching on, but for temperatures and hour counters (A-26)."""
        self.release.restart()
        self.messages.restart()
        self.charging.restart()
        self.discharging.restart_calibration()
        self.load({**values, Parameter.KEYBOARD_LOCK: 0})  # 2002h:1Ch
        self.grant(Source.AUTOSTART)
        self._react()

    def load(self, values: Mapping[Parameter, int]) -> None:
        """Take over many parameters, stored ones or those of the factory; they act at once."""
        self.parameters.load({**values, **self._fixed})
        self.release.restrict(self.enabled)
        self._touched = True

    def write(self, parameter: Parameter, value: int) -> None:
        """Set one parameter, whose constant limits have been checked.

        Raises:
            OutOfRange: beyond the limit that another parameter sets; nothing has changed.
        """
        self.parameters.write(parameter, value)
        if parameter in AFTER_WRITE:
            AFTER_WRITE[parameter](self)
        self._touched = True

    def grant(self, source: Source) -> None:
        """A source gives the software release; without effect if it is not enabled (A-40)."""
        if source in self.enabled:
            self.release.set(source, self.now)
            self._touched = True

    def revoke(self, source: Source) -> None:
        """A source takes the software release away, whoever gave it (A-40)."""
        if source in self.enabled:
            self.release.reset()
            self._touched = True

    def press(self, key: Key) -> None:
        """A key of the keypad; without effect while the keyboard is locked (2002h:1Ch)."""
        if not self.parameters[Parameter.KEYBOARD_LOCK]:
            {Key.ON: self.grant, Key.OFF: self.revoke}[key](Source.HMI)

    def clear(self, kind: Kind, number: int) -> None:
        """2003h: a message goes if it is active and its cause is gone (A-35)."""
        message = self.messages.find(kind, number)
        if message is None:
            return
        if counter := COUNTER.get((kind, message.key)):
            self.charging.sparks.reset(counter)
        self.messages.clear(message, self.situation)
        self._react()
        self._touched = True

    def force(self, message: Message) -> None:
        """Report a message for a cause outside the model; it cannot be cleared for now."""
        self.messages.force(message)
        self._react()
        self._touched = True

    def unforce(self, message: Message) -> None:
        """That cause is gone; the message stays until it is cleared."""
        self.messages.unforce(message)

    def spark(self, current: float, rise_time: float = 0.0) -> None:
        """A spark: the current rises by so many A within so many s; none without high voltage."""
        if self.charging_active:
            self.charging.spark(self.now, current, rise_time)
            self._touched = True

    def surround(self, **changes: Any) -> None:
        """Change the surroundings; the names are those of `Surroundings`."""
        self.surroundings = replace(self.surroundings, **changes)
        closed = self.surroundings.hardware_release
        (self.release.close if closed else self.release.open)()
        if "storm" in changes:
            self.charging.expect(self.surroundings.storm)
        self._touched = True


AFTER_WRITE: Mapping[Parameter, Callable[[Charger], None]] = {
    Parameter.RELEASE_MODE: lambda charger: charger.release.restrict(charger.enabled),
    Parameter.RELEASE_TIMEOUT: lambda charger: charger.release.rewind(charger.now),
    Parameter.POLLUTION_DETECTION: lambda charger: charger.charging.calibration.restart(),
    Parameter.NOMINAL_RESISTOR: lambda charger: charger.charging.calibration.restart(),
    Parameter.POLLUTION_DETECTION_DISCHARGING: lambda charger: (
        charger.discharging.restart_calibration()
    ),
}
