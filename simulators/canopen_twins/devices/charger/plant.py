"""A charger as the settings have it ordered, and what its display shows."""

from collections.abc import Callable, Mapping
from dataclasses import fields

from canopen_twins.devices.charger.model.bars import Bars
from canopen_twins.devices.charger.model.charger import Charger
from canopen_twins.devices.charger.model.load import Electrode, Resistor, Web
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.sparks import Counting, Sparks, SparkValue
from canopen_twins.devices.charger.model.surroundings import Surroundings
from canopen_twins.devices.charger.model.types import TYPES, Build, Mode, Variant
from canopen_twins.devices.charger.settings import Settings
from canopen_twins.errors import UserError
from canopen_twins.files.convert import convert

TO_MICRO = 1e6


def build(settings: Settings) -> Build:
    """Type and variant."""
    variant = Variant("" if settings.variant == "base" else settings.variant)
    return Build(TYPES[settings.kind], variant, superset=settings.variant_policy == "superset")


def detector(settings: Settings) -> Sparks:
    """The spark detector, by the reading of the manual that is wanted (A-56, A-57)."""
    return Sparks(Counting(settings.spark_classes), SparkValue[settings.spark_value.upper()])


def display(charger: Charger) -> Mapping[str, object]:
    """The output and what acts on it, in engineering units."""
    output, discharge = charger.charging.output, charger.discharging.now
    return {
        "release": charger.release.state.name,
        "mode": Mode(charger.parameters[Parameter.MODE]).name,
        "voltage [V]": round(output.voltage),
        "current [uA]": round(output.current * TO_MICRO),
        "power [W]": round(output.power, 1),
        "limited by": output.limiter.value if output.limiter else "nothing",
        "discharging [V]": round(discharge.voltage),
        "supply [V]": round(charger.supply.voltage, 2),
        "sparks": [*charger.charging.sparks.counts.values()],
    }


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
