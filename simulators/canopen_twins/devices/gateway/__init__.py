"""Heinzmann governor behind its CANopen gateway (manual DG 04 005-e / 07-04): two control units."""

from collections.abc import Collection, Iterable, Mapping, Sequence

from canopen import ObjectDictionary

from canopen_twins.device import device
from canopen_twins.device.chart import Chart
from canopen_twins.device.device import Message
from canopen_twins.device.faults import Fault
from canopen_twins.device.timing import Timing
from canopen_twins.devices.gateway import delivery
from canopen_twins.devices.gateway.chart import chart
from canopen_twins.devices.gateway.faults import faults
from canopen_twins.devices.gateway.messages import MESSAGES, emergencies, report, silence
from canopen_twins.devices.gateway.model.buffers import Buffer
from canopen_twins.devices.gateway.model.configuration import PARTNER_NODE
from canopen_twins.devices.gateway.model.state import MasterCommand
from canopen_twins.devices.gateway.model.system import System
from canopen_twins.devices.gateway.model.timing import GRID
from canopen_twins.devices.gateway.object_dictionary import PROFILE, fill, identify, objects
from canopen_twins.devices.gateway.settings import Settings
from canopen_twins.devices.gateway.traffic import STATES, Traffic
from canopen_twins.devices.gateway.units import DcDesk, Units
from canopen_twins.errors import UserError
from canopen_twins.slave.emcy import Emcy
from canopen_twins.slave.object import Address, Object
from canopen_twins.slave.service import Service, State
from canopen_twins.slave.slave import Slave

MICROSECOND = 1e-6  # s
BIT_RATE = 426  # kbit/s (7.2.2)
ANALOG_OUTPUTS = (0x2001, 0x2002)
COMMANDS = {  # Figure 3
    State.OPERATIONAL: MasterCommand.OPERATIONAL,
    State.STOPPED: MasterCommand.STOP,
    State.PRE_OPERATIONAL: MasterCommand.PRE_OPERATIONAL,
}


class Device(device.Device):
    """Both units and what is wired to them; the state machine in the gateway rules the node."""

    eds = "gateway.eds"
    title = "Heinzmann digital governor behind a CANopen gateway (manual DG 04 005-e / 07-04)"
    settings = Settings()
    profile = PROFILE
    cycle = GRID * MICROSECOND

    def check(self) -> None:
        """What the files say, and whether the times fit."""
        delivery.system(self.settings)
        delivery.configuration(self.settings)
        settings = self.settings
        if settings.overspeed <= settings.highest_speed:
            raise UserError(
                f"overspeed: {settings.overspeed:g} rpm is not above highest_speed,"
                f" {settings.highest_speed:g} rpm (A-56)"
            )
        if settings.speed > settings.highest_speed:
            raise UserError(
                f"speed: {settings.speed:g} rpm is above highest_speed,"
                f" {settings.highest_speed:g} rpm (A-56)"
            )

    def make_model(self) -> None:
        """Both units as delivered, with what the memory has kept."""
        units = Units()
        units.renew(self.settings, self.memory, self.timing)
        self.units = units  # settings that are refused leave those before

    def apply(self) -> None:
        """What surrounds the engine follows at once."""
        self.units.apply(self.settings)

    @property
    def system(self) -> System:
        """The model; power-on makes a new one."""
        return self.units.system

    @property
    def governor(self) -> DcDesk:
        """DcDesk, connected to the governor."""
        return DcDesk(self.system.governor, self.units)

    @property
    def gateway(self) -> DcDesk:
        """DcDesk, connected to the gateway."""
        return DcDesk(self.system.gateway, self.units)

    @property
    def bit_rate(self) -> int:
        """Parameter 426, as the next start finds it, in bit/s."""
        return int(self.units.parameters[BIT_RATE]) * 1000

    @property
    def timing(self) -> Timing:
        """What the units need to start, `boot_time`, passes in the model.

        Requests wait only for answers that take their time (A-60).
        """
        given = super().timing
        waits = given.requests_wait and bool(given.answer_time or given.answer_jitter)
        return given._replace(boot_time=0.0, requests_wait=waits)

    @property
    def measured(self) -> Collection[Address]:
        """The analog outputs (5.1)."""
        return [address for address in self.objects if address[0] in ANALOG_OUTPUTS]

    @property
    def node_id(self) -> int:
        """Parameter 427 in force, or as the next start finds it."""
        return self.units.node_id

    @property
    def online(self) -> bool:
        """Whether the gateway communicates: it is initialised by the governor (chapter 3)."""
        return self.system.state in STATES

    @property
    def silence(self) -> str:
        """What the units are about, and their errors."""
        return silence(self.system)

    @property
    def nmt_state(self) -> State | None:
        """The state of the gateway, which leaves Operational by itself as well (9.5)."""
        return STATES.get(self.system.state)

    @property
    def rest(self) -> float:
        """Until the next main cycle of a unit, or the next telegram between them."""
        return self.system.rest

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Chapter 5, and the error register; everything else is fixed at initialisation."""
        system = self.system
        shown = self.settings.error_register == "bits"
        register = Object(read=lambda: system.error_register if shown else 0)
        return {(0x1001, 0): register, **objects(system)}

    @property
    def emergencies(self) -> Sequence[Emcy]:
        """None, as the device; with the extension what 2005h and 1001h tell (A-01)."""
        wanted = self.settings.emcy == "assumed"
        return emergencies(self.system, self.node_id) if wanted else ()

    @property
    def has_emergencies(self) -> bool:
        """Only with the extension (A-01)."""
        return self.settings.emcy == "assumed"

    @property
    def messages(self) -> Mapping[str, Message]:
        """The bits of 2005h."""
        return MESSAGES

    @property
    def faults(self) -> Mapping[str, Fault]:
        """Causes in the units, between them and around them."""
        return faults(self.units)

    @property
    def report(self) -> Mapping[str, object]:
        """Both units and the engine, as a service engineer and an operator see them."""
        return report(self.system)

    @property
    def chart(self) -> Chart:
        """The engine, and what the governor does with it."""
        return chart(self.units)

    def dictionary(self) -> ObjectDictionary:
        """The EDS with what the handshake has created, or will create (A-03)."""
        od = super().dictionary()
        fill(od, self.system.dictionary or self.system.planned)
        identify(od, self.units.parameters, self.system.gateway)
        return od

    def pdos(self, slave: Slave) -> Iterable[Service]:
        """What is sent and when is the governor's business (4); it comes with all traffic."""
        partner = self.units.parameters[PARTNER_NODE]
        measured = self.measured if self.timing.measures else ()
        traffic = Traffic(slave, self.system, partner, self.units.disturbance, measured)
        traffic.begin()
        yield traffic

    def power_on(self) -> None:
        """Supply comes to both units; the engine is as it is (A-54)."""
        engine = self.system.governor.engine
        self.units.renew(self.settings, self.memory, self.timing, engine)
        self.system.power_on()

    def power_off(self) -> None:
        """Supply goes: actuator and generator breaker fall off, and the engine runs down (A-54)."""
        self.system.power_off()

    def step_unpowered(self, dt: float) -> None:
        """The engine runs down, its oil and its charge air with it."""
        self.system.governor.engine.run(dt)

    def reset_node(self) -> None:
        """Init, not a reset of the control unit (A-08)."""
        self.system.command(MasterCommand.RESET_NODE)

    def reset_communication(self) -> None:
        """The same (A-08)."""
        self.system.command(MasterCommand.RESET_COMMUNICATION)

    def on_request_lost(self) -> None:
        """The SDO buffer overflows (9.5, 12424)."""
        self.system.overflow(Buffer.SDO_TRANSMIT)

    def on_state(self, state: State) -> None:
        """A command of the master; what the gateway has entered by itself it is in already."""
        if state in COMMANDS:
            self.system.command(COMMANDS[state])

    def step(self, dt: float) -> None:
        """Let time pass in both units and in the engine."""
        units = self.units
        units.system.step(dt)
        units.keep_news()
