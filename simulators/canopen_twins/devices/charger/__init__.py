"""Eltex POWER CHARGER, types PCSC, PCMT, PCRT and PCTL, with its variants /A and /C."""

import logging
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import cast

from canopen import ObjectDictionary
from canopen.objectdictionary import ODRecord, ODVariable

from canopen_twins.device import (
    Address,
    Chart,
    Emcy,
    Fault,
    Message,
    Object,
    Rejected,
    Service,
    Slave,
    device,
)
from canopen_twins.devices.charger import communication, messages
from canopen_twins.devices.charger.chart import chart
from canopen_twins.devices.charger.communication import CYCLE, HEARTBEAT, Network, Place
from canopen_twins.devices.charger.faults import Change, Faults
from canopen_twins.devices.charger.model.charger import Charger
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.ticks import MINUTE, TICK, TICK_MS
from canopen_twins.devices.charger.model.types import Mode
from canopen_twins.devices.charger.object_table import addresses, factory, file_name
from canopen_twins.devices.charger.objects import MEASURED, Control, actual_values
from canopen_twins.devices.charger.settings import (
    Settings,
    build,
    detector,
    hours,
    timed,
    undisturbed,
)
from canopen_twins.devices.charger.storage import Storage
from canopen_twins.slave.dictionary import dictionary
from canopen_twins.slave.lss import LssSlave

log = logging.getLogger(__name__)

NODE_ID, LED_BAR = (0x2002, 0x06), (0x2002, 0x1D)
FACTORY_BIT_TIMING = 4  # 2002h:07h
TO_MILLI, TO_MICRO = 1e3, 1e6
LONGEST_REST = 3600.0  # s


@lru_cache(maxsize=16)
def _parameters(eds: str, node_id: int) -> Mapping[int, ODVariable]:
    """The entries of 2002h, to be looked at only."""
    return cast(ODRecord, dictionary(eds, node_id)[0x2002]).subindices


class Device(device.Device):
    """The charger, its place on the bus, its memory, and what surrounds it."""

    eds = "charger_pcsc.eds"
    title = "Eltex POWER CHARGER high-voltage generator (CANopen protocol description)"
    settings = Settings()
    stored = (HEARTBEAT, CYCLE, LED_BAR)
    cycle = 0.001  # finer than a tick, for the dead time of the spark detector
    late = 0
    """Milliseconds since the last tick of the charger."""
    measured = MEASURED

    def configure(self, /, **given: object) -> None:
        """Change settings while the supply is off; what surrounds it is as delivered."""
        self._disturbances: dict[str, Change] = {}
        super().configure(**given)
        self.profile = communication.profile(self.settings)

    def check(self) -> None:
        """What no range of a single setting can say."""
        communication.check(self.settings)
        messages.catalogue(self.settings.messages)
        undisturbed(self.settings)

    @property
    def bit_rate(self) -> int:
        """In force, in bit/s; LSS, and 0x2002:07 with a reset, change it."""
        return self.network.bit_rate

    @property
    def node_id(self) -> int:
        """In force; a reset may change it (A-34)."""
        return self.network.active.node_id

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Everything that is not plain memory, of what this type and variant has."""
        exists = addresses(self.build)
        acting = {
            **communication.objects(self.settings),
            **actual_values(self.charger),
            **self.control.objects,
            **self.network.objects,
        }
        return {address: acts for address, acts in acting.items() if address in exists}

    @property
    def emergencies(self) -> Sequence[Emcy]:
        """Errors and warnings, latched until 2003h clears them."""
        return tuple(map(messages.emcy, self.charger.messages.active))

    @property
    def messages(self) -> Mapping[str, Message]:
        """Errors and warnings by kind and number."""
        return messages.told(self.catalogue)

    def farewell(self, gone: Emcy, register: int) -> Emcy:
        """Every clear is confirmed by itself (A-36)."""
        identified = self.settings.ack_payload == "identify"
        return messages.acknowledgement(gone, register, identified=identified)

    @property
    def faults(self) -> Mapping[str, Fault]:
        """Causes with their physics, and every message."""
        return Faults(
            self.charger, self.catalogue, self.memory, self._disturb, lambda: self.late
        ).by_name

    @property
    def rest(self) -> float:
        """Nothing moves in a charger that has settled; its hour counters want to be kept."""
        return min(max(self.charger.rest, TICK), LONGEST_REST) - self.late / TO_MILLI

    @property
    def report(self) -> Mapping[str, object]:
        """The charger as its own display would show it."""
        charger = self.charger
        output, discharge = charger.charging.output, charger.discharging.now
        return {
            "release": charger.release.state.name,
            "mode": Mode(charger.parameters[Parameter.MODE]).name,
            "voltage [V]": round(output.voltage),
            "current [uA]": round(output.current * TO_MICRO),
            "power [W]": round(output.power, 1),
            "limited by": charger.limiter.value if charger.limiter else "nothing",
            "discharging [V]": round(discharge.voltage),
            "supply [V]": round(charger.supply.voltage, 2),
            "sparks": [*charger.charging.sparks.counts.values()],
            "messages": [emcy.label for emcy in self.emergencies],
            "bit rate [kbit/s]": self.network.bit_rate // 1000,
        }

    @property
    def chart(self) -> Chart:
        """Its outputs and the sparks, and the state of the release."""
        return chart(self.charger)

    def dictionary(self) -> ObjectDictionary:
        """The EDS of the type and variant, with node id and heartbeat as delivered (A-01)."""
        od = super().dictionary()
        cast(ODVariable, od[HEARTBEAT[0]]).default = self.settings.heartbeat_default_ms
        cast(ODRecord, od[NODE_ID[0]])[NODE_ID[1]].default = self.settings.node_id
        return od

    def pdos(self, slave: Slave) -> Iterable[Service]:
        """One to receive, three to send in one cycle."""
        silent = self.settings.tpdo3_without_discharge == "off" and not self.build.discharges
        return communication.pdos(slave, self.on_rpdo_refused, silent=silent)

    def services(self, slave: Slave) -> Iterable[Service]:
        """LSS changes node id and bit timing."""
        yield LssSlave(slave, self.network)

    def make_model(self) -> None:
        """Cold, with what the memory has kept."""
        self.build = build(self.settings)
        self.eds = file_name(self.build)
        self.catalogue = messages.catalogue(self.settings.messages)
        self.storage = Storage(self.memory, _parameters(self.eds, self.settings.node_id))
        self._factory = factory(self.build.kind)
        self._find_place()
        values = self.storage.parameters(self._factory)
        self.charger = Charger(
            self.build,
            values,
            self.catalogue,
            detector(self.settings),
            timed=timed(self.settings),
            surroundings=undisturbed(self.settings),
        )
        self.charger.hours = self.storage.hours(hours(self.settings))
        self._saved = self.charger.hours.operating // MINUTE
        self.control = Control(self.charger)
        self.apply()
        for severity, key in self.charger.messages.unreported:
            name = severity.name.lower()
            log.warning("%s %r has no message in the catalogue", name, key)

    def power_on(self) -> None:
        """All is made anew but for the charge that is left at the terminal, and the heat."""
        former, self.late = self.charger, 0
        self.make_model()
        self.charger.inherit(former)

    def power_off(self) -> None:
        """The hour counters survive."""
        self.storage.save_hours(self.charger.hours)
        self.charger.switch_off()

    def step_unpowered(self, dt: float) -> None:
        """What is left of the charge and of the heat goes."""
        ticks, self.late = divmod(self.late + round(dt * TO_MILLI), TICK_MS)
        self.charger.step_unpowered(ticks * TICK)

    def reset_node(self) -> None:
        """81h is like power-on, but nothing cools down (A-26)."""
        self._find_place()
        self.charger.restart(self.storage.parameters(self._factory))

    def reset_communication(self) -> None:
        """82h leaves the application alone (A-26, A-49)."""
        self.network.reset_communication()

    def save(self) -> None:
        """0x1010."""
        self.storage.save_parameters(self.charger.parameters.__getitem__)
        self.network.save()

    def restore(self) -> None:
        """0x1011: at once, and all but node id and bit timing (A-32)."""
        self.storage.forget_parameters()
        self.charger.load(self._factory)

    def on_rpdo_refused(self, number: int, refusal: Rejected) -> None:
        """What is no release locks (A-45)."""
        self.control.on_rpdo_refused(refusal)

    def apply(self) -> None:
        """The surroundings follow at once, those that faults have disturbed among them."""
        wanted, present = undisturbed(self.settings), vars(self.charger.surroundings)
        for disturb in self._disturbances.values():
            wanted = disturb(wanted)
        changes = {name: value for name, value in vars(wanted).items() if value != present[name]}
        if changes:  # a storm that goes on must not begin anew
            self.charger.surround(**changes)

    def _disturb(self, name: str, change: Change | None) -> None:
        self._disturbances.pop(name, None)
        if change is not None:
            self._disturbances[name] = change
        self.apply()

    def step(self, dt: float) -> None:
        """Let time pass in the charger; a minute that has passed is kept in the hour counters."""
        ticks, self.late = divmod(self.late + round(dt * TO_MILLI), TICK_MS)
        self.charger.step(ticks * TICK)
        minutes = self.charger.hours.operating // MINUTE
        if minutes != self._saved:
            self._saved = minutes
            self.storage.save_hours(self.charger.hours)

    def _find_place(self) -> None:
        delivered = Place(self.settings.node_id, FACTORY_BIT_TIMING)
        self.network = Network(self.storage.place(delivered), self.storage.save_place)
