"""CANopen sensors and switch functions in the governor, and their monitoring (9.6, 9.7)."""

from operator import attrgetter

from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.configuration import (
    SENSORS,
    Sensor,
    monitoring,
    sensors,
    switch_functions,
)
from canopen_twins.devices.gateway.model.parameters import Store
from canopen_twins.devices.gateway.model.timing import NEVER, Watch

SWITCHES, FLAGS = 1, 3  # words of RPDO1 (4.2.1)


class Rpdo(Watch):
    """What the governor knows of one RPDO in this Operational period (A-37)."""

    words: tuple[int, ...] = ()

    def begin(self) -> None:
        """Operational was entered: nothing counts that came before."""
        super().begin()
        self.words = ()

    def take(self, words: tuple[int, ...]) -> None:
        """A telegram came."""
        self.words = words
        self.receive()

    def word(self, number: int) -> int:
        """Word 1..4 of the last telegram; 0 if it had none."""
        return self.words[number - 1] if number <= len(self.words) else 0


class Inputs:
    """Values of sensors and switch functions; those of a faulty one do not count."""

    def __init__(self, settings: Store, cycle: int) -> None:
        self.sensors = {sensor.number: sensor for sensor in sensors(settings)}
        self._errors = [
            (sensor, errors.bit(errors.FIRST_SENSOR + number - SENSORS.start))
            for number, sensor in self.sensors.items()
        ]
        self.functions = {each.number: each for each in switch_functions(settings)}
        limits = monitoring(settings, cycle)
        self.rpdos = {number: Rpdo(limit) for number, limit in enumerate(limits, start=1)}
        self._watched = [rpdo for rpdo in self.rpdos.values() if rpdo.limit]
        self.usable = False
        """Operational, and the partner's heartbeat is not missed."""

    def begin(self) -> None:
        """Operational was entered."""
        for rpdo in self.rpdos.values():
            rpdo.begin()

    def forgive(self) -> None:
        """All errors were cleared; a cause that persists trips the monitoring again."""
        for rpdo in self.rpdos.values():
            rpdo.tripped = False

    def step(self) -> None:
        """One main cycle in Operational."""
        for rpdo in self.rpdos.values():
            rpdo.step()

    @property
    def watches(self) -> bool:
        """Whether an RPDO can be missed."""
        return bool(self._watched)

    @property
    def patience(self) -> int:
        """Main cycles in Operational until an RPDO is missed."""
        return min((rpdo.patience for rpdo in self._watched), default=NEVER)

    def leap(self, cycles: int) -> None:
        """So many main cycles in Operational without any of them."""
        for rpdo in self._watched:
            rpdo.leap(cycles)

    @property
    def tripped(self) -> bool:
        """Whether a monitored RPDO is missed: 12413."""
        return any(rpdo.tripped for rpdo in self.rpdos.values())

    def faulty(self, sensor: Sensor) -> bool:
        """Whether a sensor is without a valid value (9.6; before its first RPDO: A-17)."""
        binary, analogue = self.rpdos[1], self.rpdos[sensor.rpdo]
        return (
            not self.usable
            or not analogue.arrived
            or analogue.tripped
            or binary.tripped
            or bool(binary.word(FLAGS) >> (sensor.channel - 1) & 1)
        )

    @property
    def errors(self) -> int:
        """The sensor errors, 3005 onward; bit k is error 3000+k."""
        word = 0
        for sensor, error in self._errors:
            if self.faulty(sensor):
                word |= error
        return word

    def value(self, number: int) -> int | None:
        """The internal value of a sensor 900+s; None without CANopen, or while it is faulty."""
        sensor = self.sensors.get(number)
        if sensor is None or self.faulty(sensor):
            return None
        return self.rpdos[sensor.rpdo].word(sensor.word)

    def active(self, number: int) -> bool:
        """Whether a switch function is on; off if it is not assigned or faulty (9.7, A-32)."""
        function = self.functions.get(number)
        binary = self.rpdos[1]
        if function is None or not self.usable or not binary.arrived or binary.tripped:
            return False
        return function.active(binary.word(SWITCHES))


HELD = attrgetter("words", "arrived", "tripped")
"""What is known of an RPDO."""
