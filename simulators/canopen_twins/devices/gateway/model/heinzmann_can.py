"""HEINZMANN CAN interface of one unit: who is heard, what is missed, and what 2401 to 2405 say."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.telegrams import Body, Telegram
from canopen_twins.devices.gateway.model.timing import MILLISECOND

if TYPE_CHECKING:
    from canopen_twins.devices.gateway.model.unit import ControlUnit


SHOWN = (2401, 2402, 2403, 2404, 2410, 2411)
BUS_ERROR, COMMUNICATION_ERROR = errors.bit(errors.CAN_BUS_1), errors.bit(errors.CAN_COMM_1)
SILENCE = 500 * MILLISECOND  # longer than a reset takes


@dataclass
class Wiring:
    """What can be wrong at the plug, whatever programme runs behind it."""

    bus_fault: bool = False
    """The controller reports an error that initialising it again does not cure."""
    transmit_overflow: bool = False
    receive_overflow: bool = False
    duplicate: bool = False
    """A second participant with the same type and number is connected."""


@dataclass(frozen=True)
class Numbers:
    """Which parameters configure the interface: they differ between the units (7.1.1, 7.2.1)."""

    partner: int
    enable: int


class HeinzmannCan:
    """The interface as the running programme has configured it."""

    def __init__(self, unit: "ControlUnit[Any]", of: Numbers) -> None:
        settings = unit.store
        self.enabled = bool(settings[of.enable])
        self.node = settings[401]
        self.partner = settings[of.partner]
        self._wiring, self._link, self._out, self._time = (
            unit.wiring,
            unit.link,
            unit.out,
            unit.time,
        )
        self._patience = unit.time.now + round(settings.effective(400) * 1_000_000)
        self._last_heard = unit.time.now
        self._heard = False

    @property
    def bus_fault(self) -> bool:
        """3070: nothing gets in or out."""
        return self._wiring.bus_fault or self._link.disturbed

    @property
    def connected(self) -> bool:
        """Whether anything can get in or out."""
        return self.enabled and not self.bus_fault

    def send(self, body: Body) -> None:
        """Send to the partner, if the interface is switched on and able to."""
        if self.connected and not self._wiring.transmit_overflow:
            self._out.send(Telegram(self.node, self.partner, body))

    def accepts(self, telegram: Telegram) -> bool:
        """Whether a telegram gets through to the programme: the node numbers have to match."""
        return (
            telegram.sender == self.partner
            and telegram.addressee == self.node
            and self.connected
            and not self._wiring.receive_overflow
        )

    def hear(self) -> None:
        """Note that the partner is alive."""
        self._last_heard = self._time.now
        self._heard = True

    @property
    def silent(self) -> bool:
        """Whether the partner has been silent too long: 2403, after the delay 400."""
        now = self._time.now
        return now - self._last_heard > SILENCE and self.enabled and now >= self._patience

    @property
    def failed(self) -> bool:
        """Whether this interface is a reason of 3070 or 3071."""
        return self.bus_fault or self._disturbed

    @property
    def causes(self) -> int:
        """3070 and 3071, as far as this interface is the reason; bit k is error 3000+k."""
        causes = BUS_ERROR if self.bus_fault else 0
        return causes | COMMUNICATION_ERROR if self._disturbed else causes

    @property
    def _disturbed(self) -> bool:
        wiring = self._wiring
        content = wiring.transmit_overflow or wiring.receive_overflow or wiring.duplicate
        return content or self.silent

    def shows(self, number: int) -> int:
        """One of the parameters 2401 to 2404, 2410 and 2411: bit n stands for device n (7.2.1)."""
        wiring, device = self._wiring, 1 << self.partner
        active = device if self._heard and not self.silent else 0
        return {
            2401: device * wiring.transmit_overflow,
            2402: device * wiring.receive_overflow,
            2403: device * self.silent,
            2404: int(wiring.duplicate),  # one bit, as its range says
            2410: active >> 16,
            2411: active & 0xFFFF,
        }[number]
