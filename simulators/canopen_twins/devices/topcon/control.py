"""Parts of 4000 on the wire, engineering units in the model (7.3.5-7.3.15)."""

import re
from collections.abc import Callable, Mapping
from typing import NamedTuple

from canopen_twins.devices.topcon.model import OutputStage, UnitType
from canopen_twins.devices.topcon.panel import Panel
from canopen_twins.devices.topcon.settings import Settings
from canopen_twins.slave.object import Abort, Address, Object, Rejected
from canopen_twins.slave.service import State

FULL_SCALE = 4000  # parts that make up a nominal value
LOWEST, HIGHEST = -0x8000, 0x7FFF  # of signed 16 bit


class Quantity(NamedTuple):
    """A quantity with its nominal value, in its unit."""

    nominal: float

    def parts(self, value: float) -> int:
        """As it goes over the wire: rounded half away from zero, clipped to signed 16 bit."""
        parts = FULL_SCALE * value / self.nominal
        rounded = int(parts + 0.5) if parts >= 0 else -int(0.5 - parts)
        if LOWEST <= rounded <= HIGHEST:
            return rounded
        return HIGHEST if rounded > 0 else LOWEST

    def value(self, parts: int) -> float:
        """As the model has it."""
        return parts / FULL_SCALE * self.nominal


class Scale:
    """The nominal values of a unit (0x2000-0x2003), and what they scale."""

    def __init__(self, unit: UnitType) -> None:
        self.unit = unit
        self.voltage = Quantity(unit.nominal_voltage)
        self.current = Quantity(unit.maximum_current)
        self.power = Quantity(unit.nominal_power)
        self.resistance = Quantity(unit.nominal_resistance)

    @property
    def nominal_values(self) -> Mapping[Address, Object]:
        """What a value of 4000 parts stands for (7.3.1-7.3.4), in V, A, kW and mOhm."""
        return {
            (0x2000, 0): Object(read=lambda: round(self.unit.nominal_voltage)),
            (0x2001, 0): Object(read=lambda: round(self.unit.maximum_current)),
            (0x2002, 0): Object(read=lambda: round(self.unit.nominal_power / 1e3)),
            (0x2003, 0): Object(read=lambda: round(self.unit.nominal_resistance * 1e3)),
        }


WIDE_FROM = [4, 20]  # firmware from which addresses have 24 bits


class Registers:
    """The card's window on a sparse store of 16-bit registers; unwritten ones read 0 (A-56)."""

    def __init__(self, firmware: str, values: dict[int, int], panel: Panel) -> None:
        version = [int(number) for number in re.findall(r"\d+", firmware)]
        self.address_bits = 24 if version >= WIDE_FROM else 16
        self.address = 0
        self._values = values
        self._panel = panel

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Address and value."""
        return {
            (0x2100, 1): Object(read=lambda: self.address, write=self._select),
            (0x2100, 2): Object(read=lambda: self._values.get(self.address, 0), write=self._write),
        }

    def _select(self, address: int) -> None:
        if address >> self.address_bits:
            reason = f"this firmware has addresses of {self.address_bits} bits"
            raise Rejected(reason, Abort.TOO_HIGH)
        self.address = address

    def _write(self, value: int) -> None:
        if self._panel.yields(f"register {self.address:#x}"):
            self._values[self.address] = value


STOP, RUN, RESET = range(3)  # Tab. 55
MANUAL_START_IN_ERROR = 0x7A  # Tab. 74


class SetValue(NamedTuple):
    """A value of the stage that the master sets in parts."""

    name: str
    """The attribute of the output stage."""
    quantity: Quantity
    power_on: int


class Control:
    """The bus in control of the output stage, unless the panel is."""

    def __init__(
        self,
        stage: OutputStage,
        scale: Scale,
        panel: Panel,
        reset_card: Callable[[], None],
        settings: Settings,
    ) -> None:
        self.last_command = STOP  # 7.2.8: not stored, power-on is always STOP
        self._stage = stage
        self._panel = panel
        self._settings = settings
        self._reset_card = reset_card
        self._commands = {STOP: stage.stop, RUN: self._run, RESET: self._reset}
        self._state = State.INITIALISING
        self._set_values: Mapping[int, SetValue] = {
            0x2010: SetValue("voltage_reference", scale.voltage, settings.power_on_voltage),
            0x2011: SetValue("current_reference", scale.current, settings.power_on_current),
            0x2012: SetValue("power_reference", scale.power, settings.power_on_power),
            0x2013: SetValue(
                "resistance_reference", scale.resistance, settings.power_on_resistance
            ),
            0x2030: SetValue("overvoltage_level", scale.voltage, settings.power_on_overvoltage),
            0x2031: SetValue("overcurrent_level", scale.current, settings.power_on_overcurrent),
        }

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Set values read back what is in force; the command reads back what was accepted last."""
        return {
            **{(index, 0): self._object(value) for index, value in self._set_values.items()},
            (0x2014, 0): Object(lambda: self.last_command, self._command, obstacle=self._obstacle),
        }

    def power_on_values(self) -> None:
        """What is set before anybody sets it (A-42)."""
        for value in self._set_values.values():
            setattr(self._stage, value.name, value.quantity.value(value.power_on))

    def on_state(self, state: State) -> None:
        """Operational takes over from the panel (6); leaving it may stop the output (A-58)."""
        settings, left = self._settings, self._state is State.OPERATIONAL
        taken_over = state is State.OPERATIONAL and self._panel.local
        if left and settings.on_leave_operational == "stop":
            self._stage.stop()
        if taken_over and settings.on_remote == "stop":
            self._stage.stop()
        self._state = state
        self._panel.on_state(state)

    def _object(self, value: SetValue) -> Object:
        stage, name, quantity = self._stage, value.name, value.quantity

        def write(parts: int) -> None:
            if self._panel.yields(name.replace("_", " ")):
                setattr(stage, name, quantity.value(parts))

        def read() -> int:
            return quantity.parts(getattr(stage, name))

        return Object(read, write, obstacle=lambda _: self._panel.obstacle)

    def _command(self, command: int) -> None:
        if command not in self._commands:
            raise Rejected(f"no command {command}: 0 stops, 1 runs, 2 resets")
        if self._panel.yields(f"command {command}"):
            self._commands[command]()
            self.last_command = command

    def _obstacle(self, command: int) -> str:
        if command == RUN and self._stage.errors:
            return "an error is active, and RUN waits for its reset (A-47)"
        if command == RESET and self._stage.errors:
            return "the cause of an error is still there (A-49)"
        return self._panel.obstacle

    def _run(self) -> None:
        if self._stage.errors and self._settings.run_while_error == "abort":
            raise Rejected("no RUN while an error is active", Abort.DEVICE_STATE)
        if self._stage.errors and self._settings.run_while_error == "emcy":
            self._stage.trip(MANUAL_START_IN_ERROR)
        self._stage.run()  # which does nothing while an error is active

    def _reset(self) -> None:
        self._stage.reset()
        self._reset_card()
