"""What surrounds the charger: as the settings have it, with what goes wrong on top."""

from collections.abc import Callable
from dataclasses import fields

from simulators.devices.charger.model.bars import Bars
from simulators.devices.charger.model.charger import Charger
from simulators.devices.charger.model.load import Electrode, Resistor, Web
from simulators.devices.charger.model.surroundings import Surroundings
from simulators.devices.charger.settings import Settings
from simulators.errors import UserError
from simulators.kinds import convert

MICRO = 1e-6

Disturbance = Callable[[Surroundings], Surroundings]


class Plant:
    """Works out the surroundings, and tells a charger what of them has changed."""

    def __init__(self) -> None:
        self._disturbances: dict[str, Disturbance] = {}

    def disturb(self, name: str, disturbance: Disturbance) -> None:
        """Something goes wrong."""
        self._disturbances[name] = disturbance

    def calm(self, name: str) -> None:
        """It is over."""
        self._disturbances.pop(name, None)

    def surround(self, charger: Charger, settings: Settings) -> None:
        """Let a charger have it as it is now.

        Raises:
            UserError: no such load.
        """
        wanted = quiet(settings)
        for disturbance in self._disturbances.values():
            wanted = disturbance(wanted)
        changes = {
            field.name: getattr(wanted, field.name)
            for field in fields(Surroundings)
            if getattr(wanted, field.name) != getattr(charger.surroundings, field.name)
        }
        if changes:  # a storm that goes on must not begin anew
            charger.surround(**changes)


def quiet(settings: Settings) -> Surroundings:
    """When nothing is wrong.

    Raises:
        UserError: no such load.
    """
    return Surroundings(
        ambient=settings.ambient,
        electrode=electrode(settings.load),
        web=Web(settings.web_width, settings.web_speed, settings.web_charge * MICRO),
        bars=Bars(settings.bars),
    )


def electrode(text: str) -> Electrode | None:
    """What is connected in the words of a setting; none is the bar of the type.

    Raises:
        UserError: neither a bar nor a resistor.
    """
    match text.split():
        case ["bar"]:
            return None
        case ["resistor", number] | ["resistor", number, "ohm"]:
            return _resistor(number)
    raise UserError(f"setting 'load' is 'bar' or 'resistor OHM', not {text!r}")


def _resistor(number: str) -> Resistor:
    resistance = convert("setting 'load': the resistor", number, float)
    assert isinstance(resistance, float)
    if resistance <= 0:
        raise UserError(f"setting 'load': a resistor of {number} ohm is none")
    return Resistor(resistance)
