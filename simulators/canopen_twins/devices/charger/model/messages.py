"""The catalogue of messages: numbers, codes and registers for what the model knows by key."""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from math import inf
from typing import Any, NamedTuple

from canopen_twins.devices.charger.model.bars import Dirt
from canopen_twins.devices.charger.model.sparks import Counter
from canopen_twins.devices.charger.model.ticks import NEVER, Hold, whole_ticks
from canopen_twins.devices.charger.model.types import Quantity, Type

CODES = range(0x1000, 0x10000)  # what an EMCY calls an error (EMCY section of the manual)
GENERIC = 1 << 0  # the bit of the error register that every message sets


class Kind(Enum):
    """Errors and warnings; the value is the byte `Type` of an EMCY."""

    ERROR = 0x01
    WARNING = 0x05


NUMBERS = {Kind.ERROR: range(1, 0x51), Kind.WARNING: range(1, 0x61)}  # 2003h:01h and 02h


@dataclass(frozen=True)
class Message:
    """One error or warning."""

    kind: Kind
    number: int
    emcy: int
    register: int
    trips: bool = False  # whether it switches off and blocks
    key: str = ""

    def __post_init__(self) -> None:
        """Raises ValueError for numbers that no EMCY and no clear object can carry."""
        numbers = NUMBERS[self.kind]
        if self.number not in numbers:
            raise ValueError(f"number {self.number:#04x} is not in 0x01..{numbers[-1]:#04x}")
        if self.emcy not in CODES:
            raise ValueError(f"emcy {self.emcy:#06x} is not in 0x1000..0xffff")
        if self.register not in range(0x100) or not self.register & GENERIC:
            raise ValueError(f"register {self.register:#04x} is no byte with bit 0 set")
        if self.trips and self.kind is Kind.WARNING:
            raise ValueError("a warning does not trip")


class Catalogue:
    """All messages, found by kind and key or by kind and number."""

    def __init__(self, messages: Collection[Message]) -> None:
        """Raises ValueError where two messages share a number or a key."""
        self._by_number = _unique(messages, "number")
        self._by_key = _unique([message for message in messages if message.key], "key")

    def __iter__(self) -> Iterator[Message]:
        return iter(self._by_number.values())

    def numbered(self, kind: Kind, number: int) -> Message | None:
        """The message with this number, if there is one."""
        return self._by_number.get((kind, number))

    def keyed(self, kind: Kind, key: str) -> Message | None:
        """The message for what the model knows by this key; without one it is not reported."""
        return self._by_key.get((kind, key))


def _unique(messages: Collection[Message], field: str) -> dict[tuple[Kind, Any], Message]:
    found: dict[tuple[Kind, Any], Message] = {}
    for message in messages:
        value = getattr(message, field)
        if (message.kind, value) in found:
            raise ValueError(f"two {message.kind.name.lower()}s with the {field} {value!r}")
        found[message.kind, value] = message
    return found


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


GONE = {(cause.kind, cause.key): cause.gone for cause in CAUSES}


class Watch(NamedTuple):
    """A cause that is looked for, and the message for it."""

    test: Test
    hold: Hold
    message: Message


@dataclass
class Messages:
    """In the order in which they came."""

    catalogue: Catalogue
    active: list[Message] = field(default_factory=list, init=False)
    _forced: list[Message] = field(default_factory=list, init=False)
    _watches: list[Watch] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self.restart()

    @property
    def unreported(self) -> list[tuple[Kind, str]]:
        """What the model notices but the catalogue has no message for."""
        keys = ((cause.kind, cause.key) for cause in CAUSES)
        return [key for key in keys if self.catalogue.keyed(*key) is None]

    @property
    def tripped(self) -> bool:
        """Whether an error is active that switches off."""
        return any(message.trips for message in self.active)

    def has(self, kind: Kind) -> bool:
        """Whether an error, or a warning, is active."""
        return any(message.kind is kind for message in self.active)

    def find(self, kind: Kind, number: int) -> Message | None:
        """The active message with this number."""
        wanted = (kind, number)
        return next((m for m in self.active if (m.kind, m.number) == wanted), None)

    def force(self, message: Message) -> None:
        """A cause outside the model: the message appears, and cannot be cleared for now."""
        if message not in self._forced:
            self._forced.append(message)
        self._latch(message)

    def unforce(self, message: Message) -> None:
        """The cause outside the model is gone; the message stays until it is cleared."""
        if message in self._forced:
            self._forced.remove(message)

    def clear(self, message: Message, situation: Situation) -> None:
        """Take a message away after the internal check: its cause must be gone (A-35)."""
        gone = GONE.get((message.kind, message.key))
        if message not in self._forced and (gone is None or gone(situation)):
            self.active.remove(message)

    def restart(self) -> None:
        """Nothing is active; what still has its cause comes back."""
        self._watches = [
            Watch(cause.test, Hold(whole_ticks(cause.delay)), message)
            for cause in CAUSES
            if (message := self.catalogue.keyed(cause.kind, cause.key))
        ]
        self.active.clear()
        for message in self._forced:
            self._latch(message)

    def judge(self, now: int, situation: Situation) -> None:
        """Latch what has appeared."""
        for test, hold, message in self._watches:
            hold.update(now, test(situation))
            if hold.due(now):
                self._latch(message)

    def quiet(self, now: int) -> int:
        """Ticks until something may appear by itself."""
        return min((watch.hold.quiet(now) for watch in self._watches), default=NEVER)

    def _latch(self, message: Message) -> None:
        if message not in self.active:
            self.active.append(message)
