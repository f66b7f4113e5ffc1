"""What makes the charger report something: one row per cause, thresholds assumed (A-37)."""

from collections.abc import Callable, Iterator, Mapping
from math import inf
from typing import NamedTuple

from simulators.devices.charger.model.bars import Dirt
from simulators.devices.charger.model.catalogue import Kind
from simulators.devices.charger.model.sparks import Counter
from simulators.devices.charger.model.types import Quantity, Type

HYSTERESIS = 3.0  # K below its threshold at which a temperature may be cleared
COLD = -inf


class Situation(NamedTuple):
    """What the charger looks at when it judges itself."""

    kind: Type
    supply_voltage: float  # V
    supply_power: float  # W
    temperatures: Mapping[str, float]  # degC, of the sensors there are
    counts: Mapping[Counter, int]
    sparks_limit: int
    voltage: float  # V, of the charging, as the rest
    regulator: Quantity | None
    limiter: Quantity | None  # None while a ramp runs
    limiter_warning: bool
    pollution: int  # %
    dirt: tuple[Dirt, Dirt]
    discharging_limited: bool


Test = Callable[[Situation], bool]


class Cause(NamedTuple):
    """Reported once `test` has held for `delay` seconds; may be cleared once `gone` holds."""

    kind: Kind
    key: str
    test: Test
    gone: Test
    delay: float = 0.0


def _cause(kind: Kind, key: str, test: Test, delay: float = 0.0) -> Cause:
    return Cause(kind, key, test, lambda situation: not test(situation), delay)


def _hot(sensor: str, warning: float, error: float) -> Iterator[Cause]:
    for kind, threshold in ((Kind.WARNING, warning), (Kind.ERROR, error)):
        yield _too_hot(kind, sensor, threshold)


def _too_hot(kind: Kind, sensor: str, threshold: float) -> Cause:
    return Cause(
        kind,
        f"temp_{sensor}",
        lambda situation: situation.temperatures.get(sensor, COLD) >= threshold,
        lambda situation: situation.temperatures.get(sensor, COLD) < threshold - HYSTERESIS,
    )


def _sparks(kind: Kind, key: str, counter: Counter) -> Cause:
    """2002h:18h: each counter by itself; 0 means never."""

    def test(situation: Situation) -> bool:
        return 0 < situation.sparks_limit <= situation.counts[counter]

    return _cause(kind, key, test)


def _limiter(quantity: Quantity) -> Cause:
    """2002h:1Bh; after a second without a ramp (A-66)."""

    def test(situation: Situation) -> bool:
        return situation.limiter_warning and situation.limiter is quantity

    return _cause(Kind.WARNING, f"limiter_{quantity.value}", test, delay=1.0)


def _dirty(connector: int) -> Cause:
    key = f"pollution_discharging_{connector}"
    return _cause(Kind.WARNING, key, lambda s: s.dirt[connector - 1] is not Dirt.NONE)


CAUSES: tuple[Cause, ...] = (
    _cause(Kind.WARNING, "supply_low", lambda s: s.supply_voltage < 20.0),
    _cause(Kind.ERROR, "supply_low", lambda s: s.supply_voltage < 18.0, delay=0.1),
    _cause(Kind.WARNING, "supply_high", lambda s: s.supply_voltage > 28.8),
    _cause(Kind.ERROR, "supply_high", lambda s: s.supply_voltage > 30.0, delay=0.1),
    _cause(Kind.ERROR, "supply_current", lambda s: s.supply_power > s.kind.supply_power, delay=1.0),
    *_hot("power_stage", warning=75.0, error=85.0),
    *_hot("inside", warning=60.0, error=70.0),
    *_hot("cascade", warning=70.0, error=80.0),
    *_hot("discharging", warning=70.0, error=80.0),
    _sparks(Kind.ERROR, "strong_sparks", Counter.STRONG_ERROR),
    _sparks(Kind.WARNING, "strong_sparks", Counter.STRONG_WARNING),
    _sparks(Kind.ERROR, "weak_sparks", Counter.WEAK_ERROR),
    _sparks(Kind.WARNING, "weak_sparks", Counter.WEAK_WARNING),
    _cause(Kind.ERROR, "output_overvoltage", lambda s: s.voltage > 1.1 * s.kind.maximum_voltage),
    _cause(
        Kind.ERROR,
        "output_short",
        lambda s: s.regulator is Quantity.CURRENT and s.voltage < 0.5 * s.kind.minimum_voltage,
        delay=1.0,
    ),
    _limiter(Quantity.VOLTAGE),
    _limiter(Quantity.CURRENT),
    _limiter(Quantity.POWER),
    _cause(Kind.WARNING, "pollution_charging", lambda s: s.pollution >= 50, delay=10.0),
    _dirty(1),
    _dirty(2),
    _cause(
        Kind.WARNING,
        "limiter_discharging",
        lambda s: s.limiter_warning and s.discharging_limited,
        delay=1.0,
    ),
)
COUNTER = {  # the counter that starts afresh when its message is cleared
    (Kind.ERROR, "strong_sparks"): Counter.STRONG_ERROR,
    (Kind.WARNING, "strong_sparks"): Counter.STRONG_WARNING,
    (Kind.ERROR, "weak_sparks"): Counter.WEAK_ERROR,
    (Kind.WARNING, "weak_sparks"): Counter.WEAK_WARNING,
}
