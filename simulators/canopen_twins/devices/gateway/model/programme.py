"""What both control programmes have in common: the partner, errors, and clearing them."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.canopen_errors import NUMBERS, CanopenError, CanopenErrors
from canopen_twins.devices.gateway.model.heinzmann_can import HeinzmannCan, Numbers
from canopen_twins.devices.gateway.model.state import STATE_PARAMETERS, State, state_word
from canopen_twins.devices.gateway.model.telegrams import ClearErrors, Telegram

if TYPE_CHECKING:
    from canopen_twins.devices.gateway.model.unit import ControlUnit


ALIVE_CYCLES = 4
LINK_ERRORS = errors.bits((errors.CAN_BUS_1, errors.CAN_COMM_1))


class Programme(ABC):
    """Runs in a control unit from the end of the bootloader to the next reset, then is gone."""

    def __init__(
        self, unit: "ControlUnit[Any]", numbers: Numbers, reasons: Mapping[int, CanopenError]
    ) -> None:
        self.unit = unit
        self.settings = unit.store
        self.time = unit.time
        self.started = unit.time.now
        self.can = HeinzmannCan(unit, numbers)
        self.errors = CanopenErrors(reasons)
        self.live: dict[int, Callable[[], float]] = self._common()
        """The measurements this programme makes, by number."""
        self._pulses = 0  # errors that were there for a moment
        self._cycles = 0

    @property
    @abstractmethod
    def state(self) -> State:
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

    @property
    def alive_due(self) -> bool:
        """Whether this is one of the cycles in which the partner is told that we are alive."""
        return self._cycles % ALIVE_CYCLES == 0

    def _common(self) -> dict[int, Callable[[], float]]:
        return {
            3870: lambda: (self.time.now - self.started) // 1000 % 65536,
            12400: lambda: state_word(self.state),
            12410: lambda: int(self.errors.word),
            **{number: self._shows_state(each) for number, each in STATE_PARAMETERS.items()},
            **{number: self._shows_error(each) for number, each in NUMBERS.items()},
        }

    def _shows_state(self, state: State) -> Callable[[], float]:
        return lambda: int(self.state is state)

    def _shows_error(self, error: CanopenError) -> Callable[[], float]:
        return lambda: int(error in self.errors.word)
