"""A charger as the settings have it ordered, and what its display shows."""

from collections.abc import Mapping

from simulators.devices.charger.model.charger import Charger
from simulators.devices.charger.model.parameter import Parameter
from simulators.devices.charger.model.sparks import Counting, Sparks, SparkValue
from simulators.devices.charger.model.types import TYPES, Build, Mode, Variant
from simulators.devices.charger.settings import Settings

MICRO = 1e6


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
        "current [uA]": round(output.current * MICRO),
        "power [W]": round(output.power, 1),
        "limited by": output.limiter.value if output.limiter else "nothing",
        "discharging [V]": round(discharge.voltage),
        "supply [V]": round(charger.supply.voltage, 2),
        "sparks": [*charger.charging.sparks.counts.values()],
    }
