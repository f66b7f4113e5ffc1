"""A node that says it is another: entries of its dictionary are served with other values."""

from simulators.entry import Entry
from simulators.errors import UserError
from simulators.frame import Frame
from simulators.mischief.disturbance import Disturbance, Place
from simulators.objects import Address, Object
from simulators.slave import Slave
from simulators.wire import Onward


class Counterfeit(Disturbance):
    """Puts another entry in the place of the true one, also in the slave that a reset makes.

    Raises:
        UserError: the device has no such object.
    """

    def __init__(self, place: Place, address: Address, value: int | str) -> None:
        super().__init__(place.node)
        if place.node.device.dictionary().get_variable(*address) is None:
            raise UserError(f"the device has no object 0x{address[0]:04X}:{address[1]:02X}")
        self._address = address
        self._value = value
        self._slave: Slave | None = None
        self._true: Entry | None = None

    def start(self) -> None:
        """In the slave that is there now; every frame looks whether it is a new one."""
        self._put()
        self.node.wire.incoming.append(self._look)

    def stop(self) -> None:
        """Put the true entry back."""
        super().stop()
        self.node.wire.incoming.remove(self._look)
        index, subindex = self._address
        if self._slave is not None and self._true is not None:
            self._slave.entries[index][subindex] = self._true

    def _look(self, frame: Frame, onward: Onward) -> None:
        self._put()
        onward(frame)

    def _put(self) -> None:
        slave = self.node.slave
        if slave is None or slave is self._slave:
            return
        self._slave = slave
        index, subindex = self._address
        self._true = slave.entry(index, subindex)
        false = Entry(self._true.variable, {})
        false.bind(Object(read=lambda: false.pack(self._value)))
        slave.entries[index][subindex] = false


class Identity(Counterfeit):
    """An entry of 0x1018."""

    def __init__(self, place: Place, entry: int, value: int) -> None:
        super().__init__(place, (0x1018, entry), value)


class Firmware(Counterfeit):
    """The software version 0x100A."""

    def __init__(self, place: Place, version: str) -> None:
        super().__init__(place, (0x100A, 0), version)
