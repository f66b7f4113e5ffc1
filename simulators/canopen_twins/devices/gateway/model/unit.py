"""A control unit: what it runs off and on, from its supply to the programme that runs in it (9).

What a reset takes away is in the programme, which then is another one; what power off leaves is in
the unit. Both units are one of these; `governor` and `gateway` say what is their own.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from operator import attrgetter
from typing import Any, ClassVar, Generic, TypeVar

from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.bootloader import Bootloader, Eeprom
from canopen_twins.devices.gateway.model.canopen_side import FirstTpdo
from canopen_twins.devices.gateway.model.errors import CANOPEN_ERRORS, CanopenError, CanopenErrors
from canopen_twins.devices.gateway.model.heinzmann_can import (
    ClearErrors,
    HeinzmannCan,
    Link,
    Telegram,
    Wiring,
)
from canopen_twins.devices.gateway.model.parameters import Catalogue, Scaling, Store, Unit
from canopen_twins.devices.gateway.model.state import STATE_PARAMETERS, GatewayState, state_word
from canopen_twins.devices.gateway.model.timing import NEVER, Time, microseconds

NORMAL_SUPPLY, HIGHEST_SUPPLY = 24.0, 55.0  # V
VOLTAGE_ERROR = errors.bit(errors.VOLTAGE)
ALIVE_CYCLES = 4
LINK_ERRORS = errors.bits((errors.CAN_BUS_1, errors.CAN_COMM_1))


@dataclass(frozen=True)
class Tables:
    """What the manuals say in tables, and what is assumed in their place."""

    catalogue: Catalogue
    scaling: Scaling
    assignment: errors.Assignment


@dataclass(frozen=True)
class Options:
    """What no manual prints and a user may want otherwise; seconds are multiples of 125 us."""

    governor_cycle: float = 0.015625
    """Main cycle of the governor; the manual's formulas hold for this one (7.1.3, A-43)."""
    boot_time: float = 0.2
    """Bootloader tests and start of the programme, in both units (9.3)."""
    lowest_voltage: float = 7.5
    """Supply below which 3085 is reported, V (9.4, A-42)."""
    first_tpdo: FirstTpdo = FirstTpdo.ALWAYS
    """Whether TPDO1 to 3 are sent on entering Operational (A-15)."""
    always_armed: bool = False
    """Whether the partner is missed in Operational even before its first heartbeat (A-19)."""
    answer_time: float = 0.0
    """For an SDO request, s; if there is any, its buffers can overflow (A-60)."""
    speed_noise: float = 0.0
    """Of the measured speed of a turning engine, up and down, rpm (A-59)."""
    seed: int = 0
    """Of the noise."""


@dataclass
class Surroundings:
    """What both units share."""

    tables: Tables
    options: Options
    time: Time = field(default_factory=Time)
    link: Link = field(init=False)

    def __post_init__(self) -> None:
        self.link = Link(self.time)


class Programme(ABC):
    """Runs in a control unit from the end of the bootloader to the next reset, then is gone."""

    def __init__(
        self, unit: "ControlUnit[Any]", can: HeinzmannCan, reasons: Mapping[int, CanopenError]
    ) -> None:
        self.unit = unit
        self.settings, self.time, self.can = unit.store, unit.time, can
        self.errors = CanopenErrors(reasons)
        self.live: dict[int, Callable[[], float]] = self._common()
        """The measurements this programme makes, by number."""
        self._pulses = 0  # errors that were there for a moment
        self._cycles = 0

    @property
    @abstractmethod
    def state(self) -> GatewayState:
        """The CANopen state machine, or the governor's copy of it."""

    @abstractmethod
    def tick(self) -> None:
        """One main cycle."""

    @abstractmethod
    def handle(self, telegram: Telegram) -> None:
        """Act on a telegram of the partner."""

    def receive(self, telegram: Telegram) -> None:
        """Take a telegram from the link."""
        if self.can.accepts(telegram):
            self.can.hear()
            self.handle(telegram)

    def clear_errors(self) -> None:
        """Clear all errors here and, over the link, in the partner (9.1)."""
        self.clear()
        self.can.send(ClearErrors())

    def clear(self) -> None:
        """Clear all errors here; a cause that is still there is reported in the next cycle."""
        self._pulses = 0
        self.unit.memory.clear()
        self.errors.clear(self.causes)

    @property
    def causes(self) -> int:
        """What is wrong at this moment, 3074 left aside; bit k is error 3000+k."""
        return self.unit.causes | self.can.causes | self._pulses

    @property
    def link_failed(self) -> bool:
        """Whether 3070 or 3071 is there: nothing but the interface causes them."""
        return self.can.failed or bool(self._pulses & LINK_ERRORS)

    def evaluate(self) -> None:
        """Report what is wrong, and count what was not there before."""
        causes = self.causes
        self.errors.latch(causes)
        if self.errors.word:
            causes |= errors.bit(errors.CAN_OPEN)
        self.unit.memory.update(causes)

    def cycles_since_alive(self, cycles: int) -> int:
        """How long ago the partner will have been told that we are alive, so many from now."""
        return (self._cycles + cycles - 1) % ALIVE_CYCLES

    @property
    def alive_due(self) -> bool:
        """Whether this is one of the cycles in which the partner is told that we are alive."""
        return self._cycles % ALIVE_CYCLES == 0

    def _common(self) -> dict[int, Callable[[], float]]:
        return {
            12400: lambda: state_word(self.state),
            12410: lambda: int(self.errors.word),
            **{number: self._shows_state(each) for number, each in STATE_PARAMETERS.items()},
            **{number: self._shows_error(each) for number, each in CANOPEN_ERRORS.items()},
        }

    def _shows_state(self, state: GatewayState) -> Callable[[], float]:
        return lambda: int(self.state is state)

    def _shows_error(self, error: CanopenError) -> Callable[[], float]:
        return lambda: int(error in self.errors.word)


class Life(Enum):
    """What a control unit is about."""

    OFF = "switched off"
    STARTING = "in the start tests"
    BOOTLOADER = "kept in the bootloader"
    RUNNING = "running"


P = TypeVar("P", bound=Programme)


class ControlUnit(ABC, Generic[P]):
    """The hardware, and the life of its programme."""

    which: ClassVar[Unit]
    partner: ClassVar[Unit]
    inner_faults: ClassVar[tuple[int, ...]]
    """Errors `fail` can cause; the others have causes of their own."""

    def __init__(self, around: Surroundings, cycle: int) -> None:
        self.time, self.link = around.time, around.link
        self.cycle = cycle
        """Main cycle, us."""
        self.boot_time = microseconds(around.options.boot_time)
        """Bootloader tests and start of the programme, us (9.3)."""
        catalogue = around.tables.catalogue
        self.parameters = catalogue.of(self.which)
        self.store = Store(catalogue.defaults(self.which, writable=True))
        self.memory = errors.ErrorMemory()
        self.exception = (0, 0, 0, 0)
        """3195 to 3198 of the permanent memory: number, address low and high, flags."""
        self.bootloader = Bootloader()
        self.wiring = Wiring(self.link, self.link.to[self.partner])
        self._lowest_voltage = around.options.lowest_voltage
        self.shown = {**catalogue.defaults(self.which, writable=False)}
        """Measurements nothing in the model makes."""
        self.supply = NORMAL_SUPPLY
        """V"""
        self.cold = True
        """Whether the supply came with the last start, which else was a reset."""
        self.life = Life.OFF
        self.programme: P | None = None
        self.due = NEVER
        """When the start tests or the running main cycle end, us."""
        self._failing = 0
        self._since = 0  # the last reset, us

    @abstractmethod
    def start(self) -> P:
        """The programme, as it begins."""

    def reset(self) -> None:
        """Lose what is not saved and begin with the bootloader; also switches on."""
        self.cold = self.life is Life.OFF
        self.power_off()
        self.life, self._since = Life.STARTING, self.time.now
        self.due = self.time.now + self.boot_time

    def power_off(self) -> None:
        """Lose what is not saved and do nothing any more."""
        self.programme, self.due, self.life = None, NEVER, Life.OFF
        self.memory.clear()
        self.link.disconnect(self.which)

    def act(self) -> None:
        """Do what is due: hand on from the bootloader, or one main cycle."""
        if self.programme is None:
            self._boot()
        if self.programme is not None:
            self.due = self.time.now + self.cycle
            self.programme.tick()

    def _boot(self) -> None:
        self.due = NEVER
        if self.bootloader.stays:
            self.life = Life.BOOTLOADER
            return
        if self.bootloader.damaged(Eeprom.ERROR_MEMORY):
            self.memory.clear_counts()
        self.store.load(damaged=self.bootloader.damaged(Eeprom.PARAMETERS))
        if not self.store[4416]:
            self.link.connect(self.which, self.store[416])
        self.life, self.programme = Life.RUNNING, self.start()

    def receive(self, telegram: Telegram) -> None:
        """Take a telegram from the link; without a programme nobody listens."""
        if self.programme is not None:
            self.programme.receive(telegram)

    def after(self, cycles: int) -> int:
        """When the last of the next main cycles is due, us."""
        return self.due + (cycles - 1) * self.cycle

    def cycles_until(self, end: int) -> tuple[int, int]:
        """How many main cycles are due up to a moment, us, and when the last of them is."""
        ticks = (end - self.due) // self.cycle + 1 if self.due <= end else 0
        return ticks, self.due + (ticks - 1) * self.cycle

    @property
    def live(self) -> Mapping[int, Callable[[], float]]:
        """The measurements of the running programme, by number."""
        return {} if self.programme is None else self.programme.live

    @property
    def causes(self) -> int:
        """What is wrong within the unit itself; bit k is error 3000+k."""
        low = self.supply < self._lowest_voltage
        return self._failing | VOLTAGE_ERROR * low

    @property
    def timer(self) -> float:
        """3870: seconds since the reset, in 16 bits of milliseconds (A-26)."""
        return (self.time.now - self._since) // 1000 % 65536 / 1000

    @property
    def parameters_of_next_start(self) -> Store:
        """What the next start will find."""
        return self.store.after_reset(damaged=self.bootloader.damaged(Eeprom.PARAMETERS))

    def feed(self, volts: float) -> None:
        """Let the supply have this voltage.

        Raises:
            ValueError: not in 0..55 V.
        """
        if not 0 <= volts <= HIGHEST_SUPPLY:
            raise ValueError(f"{volts!r} V is not in 0..{HIGHEST_SUPPLY:g}")
        self.supply = volts

    def fail(self, number: int) -> None:
        """Let an inner error have a cause from now on.

        Raises:
            ValueError: not one of the inner errors of this unit.
        """
        self._failing |= self._inner(number)

    def mend(self, number: int) -> None:
        """Take the cause of an inner error away; the error may have to be cleared.

        Raises:
            ValueError: not one of the inner errors of this unit.
        """
        self._failing &= ~self._inner(number)

    def break_off(self, number: int, address: int = 0, flags: int = 0) -> None:
        """Let the programme run into an exception: 3094, kept in 3195 to 3198 (9.3.3)."""
        self.exception = (number, address & 0xFFFF, address >> 16 & 0xFFFF, flags)
        self.fail(errors.INTERN)

    def _inner(self, number: int) -> int:
        if number not in self.inner_faults:
            raise ValueError(f"error {number} is no inner error of the {self.which.value}")
        return errors.bit(number)


HELD = attrgetter("programme", "supply", "_failing", "memory.present")
"""What a unit is about, and what is wrong within it."""
