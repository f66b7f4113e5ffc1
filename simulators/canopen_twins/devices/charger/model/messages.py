"""Errors and warnings: what the catalogue says of them, what causes them, and which are active."""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from math import inf
from typing import Any, NamedTuple

from canopen_twins.devices.charger.model.discharging import Dirt
from canopen_twins.devices.charger.model.sparks import Counter
from canopen_twins.devices.charger.model.ticks import NEVER, Hold, whole_ticks
from canopen_twins.devices.charger.model.types import Quantity, Type

CODES = range(0x1000, 0x10000)  # what an EMCY calls an error (EMCY section of the manual)
GENERIC = 1 << 0  # the bit of the error register that every message sets
HYSTERESIS = 3.0  # K below its threshold at which a temperature may be cleared
COLD = -inf


class Severity(Enum):
    """Errors and warnings; the value is the byte `Type` of an EMCY."""

    ERROR = 0x01
    WARNING = 0x05


NUMBERS = {Severity.ERROR: range(1, 0x51), Severity.WARNING: range(1, 0x61)}  # 2003h:01h and 02h


@dataclass(frozen=True)
class Message:
    """One error or warning."""

    severity: Severity
    number: int
    emcy: int
    register: int
    trips: bool = False  # whether it switches off and blocks
    key: str = ""

    def __post_init__(self) -> None:
        """Raises ValueError for numbers that no EMCY and no clear object can carry."""
        numbers = NUMBERS[self.severity]
        if self.number not in numbers:
            raise ValueError(f"number {self.number:#04x} is not in 0x01..{numbers[-1]:#04x}")
        if self.emcy not in CODES:
            raise ValueError(f"emcy {self.emcy:#06x} is not in 0x1000..0xffff")
        if self.register not in range(0x100) or not self.register & GENERIC:
            raise ValueError(f"register {self.register:#04x} is no byte with bit 0 set")
        if self.trips and self.severity is Severity.WARNING:
            raise ValueError("a warning does not trip")


class Catalogue:
    """All messages, found by severity and key or by severity and number."""

    def __init__(self, messages: Collection[Message]) -> None:
        """Raises ValueError where two messages share a number or a key."""
        self._by_number = _unique(messages, "number", lambda message: message.number)
        keyed = [message for message in messages if message.key]
        self._by_key = _unique(keyed, "key", lambda message: message.key)

    def __iter__(self) -> Iterator[Message]:
        return iter(self._by_number.values())

    def numbered(self, severity: Severity, number: int) -> Message | None:
        """The message with this number, if there is one."""
        return self._by_number.get((severity, number))

    def keyed(self, severity: Severity, key: str) -> Message | None:
        """The message for what the model knows by this key; without one it is not reported."""
        return self._by_key.get((severity, key))


def _unique(
    messages: Collection[Message], what: str, of: Callable[[Message], Any]
) -> dict[tuple[Severity, Any], Message]:
    found: dict[tuple[Severity, Any], Message] = {}
    for message in messages:
        severity, value = message.severity, of(message)
        if (severity, value) in found:
            raise ValueError(f"two {severity.name.lower()}s with the {what} {value!r}")
        found[severity, value] = message
    return found


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
    limiter: Quantity | None
    limiter_warning: bool
    pollution: int  # %
    dirt: tuple[Dirt, Dirt]
    discharging_limited: bool


Condition = Callable[[Situation], bool]


class Cause(NamedTuple):
    """Reported once `condition` has held for `delay` seconds; may be cleared once it is `gone`."""

    severity: Severity
    key: str
    condition: Condition
    delay: float = 0.0
    cleared: Condition | None = None
    """What `gone` is where it is more than that the condition does not hold."""

    def gone(self, situation: Situation) -> bool:
        """Whether the internal check lets a message go (A-35)."""
        return self.cleared(situation) if self.cleared else not self.condition(situation)


def _hot(sensor: str, warning: float, error: float) -> Iterator[Cause]:
    def at_least(threshold: float) -> Condition:
        return lambda s: s.temperatures.get(sensor, COLD) >= threshold

    def below(threshold: float) -> Condition:
        return lambda s: s.temperatures.get(sensor, COLD) < threshold

    for severity, limit in ((Severity.WARNING, warning), (Severity.ERROR, error)):
        yield Cause(severity, f"temp_{sensor}", at_least(limit), 0.0, below(limit - HYSTERESIS))


def _too_many(counter: Counter) -> Condition:
    """2002h:18h: each counter by itself; 0 means never."""
    return lambda s: 0 < s.sparks_limit <= s.counts[counter]


def _limiter(quantity: Quantity) -> Cause:
    """Not gone as long as the limiter works, wanted or not (A-35)."""
    key, condition = f"limiter_{quantity.value}", _limited(quantity)
    return Cause(Severity.WARNING, key, condition, 1.0, lambda s: s.limiter is not quantity)


def _limited(quantity: Quantity) -> Condition:
    """2002h:1Bh (A-66)."""
    return lambda s: s.limiter_warning and s.limiter is quantity


COUNTERS = {  # a counter starts afresh when its message is cleared
    (Severity.ERROR, "strong_sparks"): Counter.STRONG_ERROR,
    (Severity.WARNING, "strong_sparks"): Counter.STRONG_WARNING,
    (Severity.ERROR, "weak_sparks"): Counter.WEAK_ERROR,
    (Severity.WARNING, "weak_sparks"): Counter.WEAK_WARNING,
}
CAUSES: tuple[Cause, ...] = (
    Cause(Severity.WARNING, "supply_low", lambda s: s.supply_voltage < 20.0),
    Cause(Severity.ERROR, "supply_low", lambda s: s.supply_voltage < 18.0, 0.1),
    Cause(Severity.WARNING, "supply_high", lambda s: s.supply_voltage > 28.8),
    Cause(Severity.ERROR, "supply_high", lambda s: s.supply_voltage > 30.0, 0.1),
    Cause(Severity.ERROR, "supply_current", lambda s: s.supply_power > s.kind.supply_power, 1.0),
    *_hot("power_stage", warning=75.0, error=85.0),
    *_hot("inside", warning=60.0, error=70.0),
    *_hot("cascade", warning=70.0, error=80.0),
    *_hot("discharging", warning=70.0, error=80.0),
    *(Cause(*key, _too_many(counter)) for key, counter in COUNTERS.items()),
    Cause(Severity.ERROR, "output_overvoltage", lambda s: s.voltage > 1.1 * s.kind.maximum_voltage),
    Cause(
        Severity.ERROR,
        "output_short",
        lambda s: s.regulator is Quantity.CURRENT and s.voltage < 0.5 * s.kind.minimum_voltage,
        1.0,
    ),
    *map(_limiter, Quantity),
    Cause(Severity.WARNING, "pollution_charging", lambda s: s.pollution >= 50, 10.0),
    Cause(Severity.WARNING, "pollution_discharging_1", lambda s: s.dirt[0] is not Dirt.NONE),
    Cause(Severity.WARNING, "pollution_discharging_2", lambda s: s.dirt[1] is not Dirt.NONE),
    Cause(
        Severity.WARNING,
        "limiter_discharging",
        lambda s: s.limiter_warning and s.discharging_limited,
        1.0,
        lambda s: not s.discharging_limited,
    ),
)


class Watch(NamedTuple):
    """A cause that is looked for, and the message for it."""

    cause: Cause
    hold: Hold
    message: Message


class Messages:
    """The active messages, in the order in which they came."""

    def __init__(self, catalogue: Catalogue) -> None:
        self.catalogue = catalogue
        self.active: list[Message] = []
        self._forced: list[Message] = []
        self.calm = True
        """Whether nothing had a cause when it was last judged."""
        self.restart()

    @property
    def unreported(self) -> list[tuple[Severity, str]]:
        """What the model notices but the catalogue has no message for."""
        keys = ((cause.severity, cause.key) for cause in CAUSES)
        return [key for key in keys if self.catalogue.keyed(*key) is None]

    @property
    def tripped(self) -> bool:
        """Whether an error is active that switches off."""
        return any(message.trips for message in self.active)

    def has(self, severity: Severity) -> bool:
        """Whether an error, or a warning, is active."""
        return any(message.severity is severity for message in self.active)

    def find(self, severity: Severity, number: int) -> Message | None:
        """The active message with this number."""
        wanted = (severity, number)
        return next((m for m in self.active if (m.severity, m.number) == wanted), None)

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
        key = (message.severity, message.key)
        causes = (cause for cause in CAUSES if (cause.severity, cause.key) == key)
        if message not in self._forced and all(cause.gone(situation) for cause in causes):
            self.active.remove(message)

    def restart(self) -> None:
        """Nothing is active; what still has its cause comes back."""
        self._watches = [
            Watch(cause, Hold(whole_ticks(cause.delay)), message)
            for cause in CAUSES
            if (message := self.catalogue.keyed(cause.severity, cause.key))
        ]
        self.calm = True
        self.active.clear()
        for message in self._forced:
            self._latch(message)

    def judge(self, now: int, situation: Situation) -> None:
        """Latch what has appeared."""
        self.calm = True
        for cause, hold, message in self._watches:
            present = cause.condition(situation)
            hold.update(now, present)
            if present:
                self.calm = False
                if hold.due(now):
                    self._latch(message)

    def quiet(self, now: int) -> int:
        """Ticks until something may appear by itself."""
        if self.calm:
            return NEVER
        return min((watch.hold.quiet(now) for watch in self._watches), default=NEVER)

    def _latch(self, message: Message) -> None:
        if message not in self.active:
            self.active.append(message)
