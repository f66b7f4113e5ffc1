"""One control unit: power, bootloader, memory, CAN plug, and the programme that runs in it."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Generic, TypeVar

from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.bootloader import Bootloader, Eeprom
from canopen_twins.devices.gateway.model.errors import ErrorMemory
from canopen_twins.devices.gateway.model.heinzmann_can import Wiring
from canopen_twins.devices.gateway.model.link import Link
from canopen_twins.devices.gateway.model.options import Options
from canopen_twins.devices.gateway.model.parameters import Catalogue, Parameter, Unit
from canopen_twins.devices.gateway.model.programme import Programme
from canopen_twins.devices.gateway.model.store import Store
from canopen_twins.devices.gateway.model.telegrams import Telegram
from canopen_twins.devices.gateway.model.timing import NEVER, Time, microseconds

P = TypeVar("P", bound=Programme)

POWER_SUPPLY = 3600
VOLTAGE_ERROR = errors.bit(errors.VOLTAGE)


class Life(Enum):
    """What a control unit is about."""

    OFF = "switched off"
    STARTING = "in the start tests"
    BOOTLOADER = "kept in the bootloader"
    RUNNING = "running"


@dataclass
class Surroundings:
    """What both units share."""

    catalogue: Catalogue
    time: Time = field(default_factory=Time)
    link: Link = field(init=False)

    def __post_init__(self) -> None:
        self.link = Link(self.time)


class ControlUnit(ABC, Generic[P]):
    """The hardware; what a reset takes away is in the programme, which then is another one."""

    which: Unit
    partner: Unit
    inner_faults: tuple[int, ...]
    """Errors `fail` can cause; the others have causes of their own."""

    def __init__(self, around: Surroundings, cycle: int, options: Options) -> None:
        self.time, self.link = around.time, around.link
        self.out = self.link.to[self.partner]
        self.cycle = cycle
        """Main cycle, us."""
        self.boot_time = microseconds(options.boot_time)
        """Bootloader tests and start of the programme, us (9.3)."""
        self.parameters: Mapping[int, Parameter] = around.catalogue.of(self.which)
        self.store = Store(self.parameters)
        self.memory = ErrorMemory()
        self.exception = (0, 0, 0, 0)
        """3195 to 3198 of the permanent memory: number, address low and high, flags."""
        self.bootloader = Bootloader()
        self.wiring = Wiring()
        self._lowest_voltage = options.lowest_voltage
        self.shown = {n: each.default for n, each in self.parameters.items() if not each.writable}
        """Measurements nothing in the model makes, 3600 PowerSupply among them."""
        self.life = Life.OFF
        self.programme: P | None = None
        self.due = NEVER
        """When the start tests or the running main cycle end, us."""
        self._failing = 0

    @abstractmethod
    def start(self) -> P:
        """The programme, as it begins."""

    def reset(self) -> None:
        """Lose what is not saved and begin with the bootloader; also switches on."""
        self.power_off()
        self.life = Life.STARTING
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

    @property
    def live(self) -> Mapping[int, Callable[[], float]]:
        """The measurements of the running programme, by number."""
        return {} if self.programme is None else self.programme.live

    @property
    def causes(self) -> int:
        """What is wrong within the unit itself; bit k is error 3000+k."""
        low = self.shown[POWER_SUPPLY] < self._lowest_voltage
        return self._failing | VOLTAGE_ERROR * low

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
