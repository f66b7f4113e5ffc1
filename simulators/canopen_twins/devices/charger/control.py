"""What the master sets and commands: parameters (2002h), clearing (2003h), release (6200h)."""

from collections.abc import Mapping
from functools import partial

from canopen_twins.devices.charger.model.charger import Charger
from canopen_twins.devices.charger.model.messages import Kind
from canopen_twins.devices.charger.model.parameters import (
    SHORTEST_TIMEOUT,
    Direction,
    OutOfRange,
    Parameter,
)
from canopen_twins.devices.charger.model.release import Source, State
from canopen_twins.slave.object import Abort, Address, Object, Rejected

REFUSALS = {Direction.LOW: Abort.TOO_LOW, Direction.HIGH: Abort.TOO_HIGH}
LOCKED, RELEASED = 0x00, 0x0F  # 6200h:01h


def _no_timeout(milliseconds: int) -> str:
    short = 0 < milliseconds < SHORTEST_TIMEOUT
    return f"below {SHORTEST_TIMEOUT} ms it is kept as 0, which is no time-out" if short else ""


OBSTACLES = {Parameter.RELEASE_TIMEOUT: _no_timeout}


class Control:
    """The bus in front of a charger."""

    def __init__(self, charger: Charger) -> None:
        self._charger = charger

    @property
    def objects(self) -> Mapping[Address, Object]:
        """All that the model acts on, whatever the variant has."""
        values = self._charger.parameters
        return {
            **{
                (0x2002, parameter.value): Object(
                    read=partial(values.__getitem__, parameter),
                    write=partial(self._write, parameter),
                    obstacle=OBSTACLES.get(parameter),
                )
                for parameter in Parameter
            },
            (0x2003, 0x01): self._clearing(Kind.ERROR),
            (0x2003, 0x02): self._clearing(Kind.WARNING),
            (0x6200, 0x01): Object(write=self._release, obstacle=self._release_obstacle),
        }

    def _clearing(self, kind: Kind) -> Object:
        def obstacle(number: int) -> str:
            active = self._charger.messages.find(kind, number)
            return "its cause is still there (A-35)" if active else ""

        return Object(write=partial(self._charger.clear, kind), obstacle=obstacle)

    def on_rpdo_refused(self, refusal: Rejected) -> None:
        """A byte in the RPDO that is neither locks; one that is missing is no byte (A-25, A-45)."""
        if refusal.code == Abort.INVALID_VALUE:
            self._charger.revoke(Source.CANOPEN)

    def _write(self, parameter: Parameter, value: int) -> None:
        try:
            self._charger.write(parameter, value)
        except OutOfRange as refusal:
            raise Rejected(str(refusal), REFUSALS[refusal.direction]) from refusal

    def _release_obstacle(self, value: int) -> str:
        release = self._charger.release
        if Source.CANOPEN not in self._charger.enabled:
            return "0x2002:02 bit 3 does not let CANopen release (A-46)"
        if value == RELEASED and release.state is State.FAULT:
            return "an error blocks the release until it is cleared (A-48)"
        if value == RELEASED and not release.closed:
            return "the hardware release is open (A-47)"
        return ""

    def _release(self, value: int) -> None:
        commands = {LOCKED: self._charger.revoke, RELEASED: self._charger.grant}
        if value not in commands:
            raise Rejected(f"{value:#04x} is neither locked (0x00) nor released (0x0f)")
        commands[value](Source.CANOPEN)
