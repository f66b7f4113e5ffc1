"""What the master sets and commands (7.3.5-7.3.15): parts of 4000 here, units in the model."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from canopen_twins.device import Abort, Address, Object, Rejected, State
from canopen_twins.devices.topcon.model.stage import OutputStage
from canopen_twins.devices.topcon.model.unit import UnitType
from canopen_twins.devices.topcon.panel import Panel
from canopen_twins.devices.topcon.settings import Settings

FULL_SCALE = 4000  # parts that make up a nominal value
LOWEST, HIGHEST = -0x8000, 0x7FFF  # of signed 16 bit
STOP, RUN, RESET = range(3)  # Tab. 55
MANUAL_START_IN_ERROR = 0x7A  # Tab. 74


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
        self._scale = scale
        self._panel = panel
        self._settings = settings
        self._reset_card = reset_card
        self._commands = {STOP: stage.stop, RUN: self._run, RESET: self._reset}
        self._state = State.INITIALISING

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Set values read back what is in force; the command reads back what was accepted last."""
        command = Object(lambda: self.last_command, self._command, obstacle=self._obstacle)
        return {**self._set_values, (0x2014, 0): command}

    def power_on_values(self) -> None:
        """What is set before anybody sets it (A-42)."""
        stage, scale, settings = self._stage, self._scale, self._settings
        stage.voltage_reference = scale.voltage.value(settings.power_on_voltage)
        stage.current_reference = scale.current.value(settings.power_on_current)
        stage.power_reference = scale.power.value(settings.power_on_power)
        stage.resistance_reference = scale.resistance.value(settings.power_on_resistance)
        stage.overvoltage_level = scale.voltage.value(settings.power_on_overvoltage)
        stage.overcurrent_level = scale.current.value(settings.power_on_overcurrent)

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

    @property
    def _set_values(self) -> Mapping[Address, Object]:
        stage, scale, of = self._stage, self._scale, self._set_value

        def voltage_reference(value: float) -> None:
            stage.voltage_reference = value

        def current_reference(value: float) -> None:
            stage.current_reference = value

        def power_reference(value: float) -> None:
            stage.power_reference = value

        def resistance_reference(value: float) -> None:
            stage.resistance_reference = value

        def overvoltage_level(value: float) -> None:
            stage.overvoltage_level = value

        def overcurrent_level(value: float) -> None:
            stage.overcurrent_level = value

        return {
            (0x2010, 0): of(scale.voltage, lambda: stage.voltage_reference, voltage_reference),
            (0x2011, 0): of(scale.current, lambda: stage.current_reference, current_reference),
            (0x2012, 0): of(scale.power, lambda: stage.power_reference, power_reference),
            (0x2013, 0): of(
                scale.resistance, lambda: stage.resistance_reference, resistance_reference
            ),
            (0x2030, 0): of(scale.voltage, lambda: stage.overvoltage_level, overvoltage_level),
            (0x2031, 0): of(scale.current, lambda: stage.overcurrent_level, overcurrent_level),
        }

    def _set_value(
        self, quantity: Quantity, read: Callable[[], float], write: Callable[[float], None]
    ) -> Object:
        """A value of the stage that the master sets in parts."""
        name = write.__name__.replace("_", " ")

        def write_parts(parts: int) -> None:
            if self._panel.yields(name):
                write(quantity.value(parts))

        return Object(
            lambda: quantity.parts(read()), write_parts, obstacle=lambda _: self._panel.obstacle
        )

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
