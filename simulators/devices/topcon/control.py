"""What the master commands: set values, trip levels and the run command (7.3.5-9, 7.3.14-15)."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from simulators.devices.topcon.model import OutputStage
from simulators.devices.topcon.panel import Panel
from simulators.devices.topcon.scale import Quantity, Scale
from simulators.devices.topcon.settings import Settings
from simulators.objects import Abort, Address, Object, Rejected
from simulators.services import State

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
