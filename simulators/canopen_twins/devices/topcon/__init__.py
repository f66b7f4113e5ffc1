"""Regatron TopCon Quadro behind a TC.CANOPEN card (manual DO6130.0031 V02.62)."""

from collections.abc import Iterable, Mapping, Sequence
from typing import cast

from canopen import ObjectDictionary
from canopen.objectdictionary import ODVariable

from canopen_twins.device import (
    Abort,
    Address,
    Chart,
    Emcy,
    Fault,
    Message,
    Object,
    Rejected,
    Service,
    Slave,
    State,
    device,
)
from canopen_twins.devices.topcon import card, messages, units
from canopen_twins.devices.topcon.card import CardErrors, Registers
from canopen_twins.devices.topcon.chart import chart
from canopen_twins.devices.topcon.control import Control, Scale
from canopen_twins.devices.topcon.faults import faults
from canopen_twins.devices.topcon.model.stage import OutputStage
from canopen_twins.devices.topcon.model.states import Mode
from canopen_twins.devices.topcon.panel import Panel
from canopen_twins.devices.topcon.settings import Settings

RUNNING = {Mode.VOLTAGE: 1 | 1 << 1, Mode.CURRENT: 1 | 1 << 2, Mode.POWER: 1 | 1 << 3}  # Tab. 60
SET_VALUES = range(0x2010, 0x2014)
STORED = tuple((index, 0) for index in (0x2010, 0x2011, 0x2012, 0x2013, 0x2030, 0x2031))  # Tab. 45
MEASURED = tuple((index, 0) for index in (0x2020, 0x2021, 0x2022))
PARAMETER_REFUSALS = (Abort.INVALID_VALUE, Abort.TOO_HIGH, Abort.TOO_LOW, Abort.TOO_SHORT)


class Device(device.Device):
    """The card, and the unit it sits in: set values in, actual values out, errors told once."""

    eds = "topcon.eds"
    title = "Regatron TopCon Quadro DC supply (TC.CANOPEN manual DO6130.0031 V02.62)"
    settings = Settings()
    stored = STORED
    measured = MEASURED
    cycle = OutputStage.tick

    def configure(self, /, **given: object) -> None:
        """Change settings while the unit is off; its switches are read at power-on (4.2, 4.3)."""
        self._module_id: int | None = None
        super().configure(**given)
        self.profile = card.profile(self.settings)

    def check(self) -> None:
        """What the settings are together, the unit type and the load among them."""
        card.check(self.settings)
        super().check()
        units.unit_type(self.settings)
        units.load(self.settings)

    @property
    def node_id(self) -> int:
        """The module id of the switches, as they stood at power-on (4.2)."""
        return self._module_id or card.module_id(self.settings)

    @property
    def bit_rate(self) -> int:
        """What switch BR stood at, at power-on, in bit/s (4.3)."""
        return self._bit_rate

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Chapter 7.3, and what of 7.2 depends on the unit."""
        stage, scale, settings = self.stage, self.scale, self.settings
        return {
            (0x1009, 0): Object(read=lambda: settings.hardware_version),
            (0x100A, 0): Object(read=lambda: settings.firmware),
            (0x1018, 4): Object(read=lambda: settings.serial),
            **{(0x1800 + n, 1): Object(write=card.check_tpdo_cob_id) for n in range(4)},
            **scale.nominal_values,
            **self.control.objects,
            (0x2020, 0): Object(read=lambda: scale.voltage.parts(stage.voltage)),
            (0x2021, 0): Object(read=lambda: scale.current.parts(stage.current)),
            (0x2022, 0): Object(read=lambda: scale.power.parts(stage.power)),
            (0x2023, 0): Object(read=self._state_of_output),
            **self.registers.objects,
        }

    @property
    def emergencies(self) -> Sequence[Emcy]:
        """Errors of the unit and of the card, latched until command 2."""
        errors, card_errors = self.stage.errors, self.card_errors.active
        if not errors:
            return card_errors
        told = messages.unit_errors()
        return (*(told[error] for error in errors), *card_errors)

    @property
    def messages(self) -> Mapping[str, Message]:
        """The codes of chapter 8."""
        return messages.messages()

    @property
    def faults(self) -> Mapping[str, Fault]:
        """Causes with their physics, and every message of chapter 8."""
        return faults(self.stage, self._raise_card_error)

    @property
    def rest(self) -> float:
        """Nothing moves in a settled output stage."""
        return self.stage.rest

    @property
    def report(self) -> Mapping[str, object]:
        """The output as an instrument at the terminals would show it."""
        stage = self.stage
        return {
            "state": stage.state.name,
            "mode": stage.mode.name,
            "voltage [V]": round(stage.voltage, 3),
            "current [A]": round(stage.current, 3),
            "power [W]": round(stage.power, 1),
            "heat sink [degC]": round(stage.temperature, 2),
            "errors": [f"{error:#05x}" for error in stage.errors],
            "control": "panel" if self.panel.local else "bus",
            "RS-232 of the card": "available" if self.panel.rs232_available else "closed",
        }

    @property
    def chart(self) -> Chart:
        """Voltage, current and power, and the state of the output stage."""
        return chart(self.stage)

    def dictionary(self) -> ObjectDictionary:
        """The EDS, with the range of set values the settings say."""
        od = super().dictionary()
        for index in SET_VALUES:
            cast(ODVariable, od[index]).max = self.settings.set_value_range
        return od

    def make_model(self) -> None:
        """The unit, cold and empty, and its card."""
        self.stage = units.output_stage(self.settings)
        self.scale = Scale(self.stage.unit)
        self._turn_on()

    def power_on(self) -> None:
        """Supply comes, to a unit with the charge and the heat that it has (A-76)."""
        self.stage.power_on()
        self._turn_on()

    def _turn_on(self) -> None:
        """Switches are read now and not again, and the panel is remote (6)."""
        settings = self.settings
        self._module_id = card.module_id(settings)
        self._bit_rate = card.bit_rate(settings.br)
        self._register_values: dict[int, int] = {}
        self.panel = Panel(settings.quiet_time, refuses=settings.local_write == "abort")
        self._start_card()
        self.control.power_on_values()

    def power_off(self) -> None:
        """The output goes with the supply."""
        self.stage.power_off()

    def step_unpowered(self, dt: float) -> None:
        """Capacitor, bleeder, heat and load go on without supply (A-76)."""
        self.stage.drain(dt)

    def reset_node(self) -> None:
        """The card starts anew; errors of the unit stay (A-60).

        It stops the output and forgets the set values (A-58), unless the panel is in control: 6
        names power-on and Operational only as what takes control from it (A-88).
        """
        self._start_card()
        if not self.panel.local:
            self.stage.stop()
            self.control.power_on_values()

    def _start_card(self) -> None:
        settings = self.settings
        self.registers = Registers(settings.firmware, self._register_values, self.panel)
        self.card_errors = CardErrors()
        self.control = Control(self.stage, self.scale, self.panel, self.card_errors.reset, settings)

    def on_state(self, state: State) -> None:
        """Operational takes control away from the panel (6)."""
        self.control.on_state(state)

    def services(self, slave: Slave) -> Iterable[Service]:
        """None on the bus; while that is in use, RS-232 is not (5)."""
        self.panel.quiet = lambda: slave.quiet
        return ()

    def on_rpdo_refused(self, number: int, refusal: Rejected) -> None:
        """A parameter that exceeds its limit is told by EMCY (Tab. 82, A-37, A-41)."""
        if refusal.code in PARAMETER_REFUSALS:
            self._raise_card_error(messages.PROTOCOL_ERROR)

    def _raise_card_error(self, code: int) -> None:
        """By the card that sits in the unit now; a reset puts a fresh one there."""
        self.card_errors.add(code)

    def set(self, /, **given: object) -> None:
        """Change what may change while the unit runs.

        A load that is named is connected anew, and the panel turns.
        """
        super().set(**given)
        if "load" in given:
            self.stage.load = units.load(self.settings)
        if "panel" in given:
            self.panel.want(self.settings.panel == "local")

    def apply(self) -> None:
        """The ambient temperature follows at once, switches at power-on."""
        self.stage.ambient = self.settings.ambient

    def step(self, dt: float) -> None:
        """Let time pass in the unit."""
        self.stage.step(dt)

    def _state_of_output(self) -> int:
        stage = self.stage
        bits = RUNNING[stage.mode] if stage.running else 0
        return bits | stage.warning << 14 | bool(stage.errors) << 15  # Tab. 60
