"""Errors of CANopen communication: parameters 12411 to 12424 and their word 2005h (9.5)."""

from collections.abc import Mapping
from enum import IntFlag

from canopen_twins.devices.gateway.model import errors

FIRST = 12411
REGISTERED = errors.bits(range(3070, 3095))


class CanopenError(IntFlag):
    """Bits of 2005h (Table 2); bit k is parameter 12411+k."""

    DC_RESET = 1 << 0
    INIT = 1 << 1
    TIME_CTRL = 1 << 2
    DC_CAN_BUS = 1 << 3
    DC_CAN_COMM = 1 << 4
    GW_RESET = 1 << 8
    HEARTBEAT = 1 << 9
    GW_CAN_BUS_1 = 1 << 10
    GW_CAN_COMM_1 = 1 << 11
    GW_CAN_BUS_2 = 1 << 12
    GW_CAN_COMM_2 = 1 << 13


NUMBERS = {FIRST + each.bit_length() - 1: each for each in CanopenError}

OF_GOVERNOR: Mapping[int, CanopenError] = {
    errors.CAN_BUS_1: CanopenError.DC_CAN_BUS,
    errors.CAN_COMM_1: CanopenError.DC_CAN_COMM,
}
OF_GATEWAY: Mapping[int, CanopenError] = {
    errors.CAN_BUS_1: CanopenError.GW_CAN_BUS_1,
    errors.CAN_COMM_1: CanopenError.GW_CAN_COMM_1,
    errors.CAN_BUS_2: CanopenError.GW_CAN_BUS_2,
    errors.CAN_COMM_2: CanopenError.GW_CAN_COMM_2,
}


def error_register(present: int, word: CanopenError) -> int:
    """Object 1001h: generic, voltage and communication error of the gateway (A-07)."""
    generic, voltage = bool(present & REGISTERED), bool(present & errors.bit(errors.VOLTAGE))
    return generic << 0 | voltage << 2 | bool(word) << 4


class CanopenErrors:
    """What one unit knows: its own bits, and those its partner told it last (A-12)."""

    def __init__(self, reasons: Mapping[int, CanopenError]) -> None:
        self._reasons = reasons
        self._relevant = errors.bits(reasons)
        self.own = CanopenError(0)
        self.partner = CanopenError(0)

    @property
    def word(self) -> CanopenError:
        """Object 2005h, as this unit sees it."""
        if not self.partner:  # most of the time
            return self.own
        return self.own | self.partner

    def latch(self, causes: int) -> None:
        """Set what the errors 3070 to 3073 among the causes stand for; it stays when they go."""
        if causes & self._relevant:
            self.own |= self._standing_for(causes)

    def follow(self, error: CanopenError, present: bool) -> None:
        """Let an error come and go with its cause (12413, 12420)."""
        if bool(self.own.value & error.value) is not present:  # most of the time it is as it was
            self.own ^= error

    def clear(self, causes: int) -> None:
        """Clear all but what has a cause here: by clearing all errors, or in Operational (9.5).

        The partner does the same, and tells what it has left.
        """
        self.own, self.partner = self._standing_for(causes), CanopenError(0)

    def _standing_for(self, causes: int) -> CanopenError:
        present = CanopenError(0)
        for number, error in self._reasons.items():
            if causes & errors.bit(number):
                present |= error
        return present
