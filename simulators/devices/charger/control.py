"""What the master sets and commands: parameters (2002h), clearing (2003h), release (6200h)."""

from collections.abc import Mapping
from functools import partial

from simulators.devices.charger.model.catalogue import Kind
from simulators.devices.charger.model.charger import Charger
from simulators.devices.charger.model.parameter import Direction, OutOfRange, Parameter
from simulators.devices.charger.model.release import Source
from simulators.objects import Abort, Address, Object, Rejected

REFUSALS = {Direction.LOW: Abort.TOO_LOW, Direction.HIGH: Abort.TOO_HIGH}
LOCKED, RELEASED = 0x00, 0x0F  # 6200h:01h


class Control:
    """The bus in front of a charger."""

    def __init__(self, charger: Charger) -> None:
        self._charger = charger

    @property
    def objects(self) -> Mapping[Address, Object]:
        """All that the model acts on, whatever the variant has."""
        values, charger = self._charger.parameters, self._charger
        return {
            **{
                (0x2002, parameter.value): Object(
                    read=partial(values.__getitem__, parameter),
                    write=partial(self._write, parameter),
                )
                for parameter in Parameter
            },
            (0x2003, 0x01): Object(write=partial(charger.clear, Kind.ERROR)),
            (0x2003, 0x02): Object(write=partial(charger.clear, Kind.WARNING)),
            (0x6200, 0x01): Object(write=self._release),
        }

    def on_rpdo_refused(self, refusal: Rejected) -> None:
        """A byte in the RPDO that is neither locks; one that is missing is no byte (A-25, A-45)."""
        if refusal.code == Abort.INVALID_VALUE:
            self._charger.revoke(Source.CANOPEN)

    def _write(self, parameter: Parameter, value: int) -> None:
        try:
            self._charger.write(parameter, value)
        except OutOfRange as refusal:
            raise Rejected(str(refusal), REFUSALS[refusal.direction]) from refusal

    def _release(self, value: int) -> None:
        commands = {LOCKED: self._charger.revoke, RELEASED: self._charger.grant}
        if value not in commands:
            raise Rejected(f"{value:#04x} is neither locked (0x00) nor released (0x0f)")
        commands[value](Source.CANOPEN)
