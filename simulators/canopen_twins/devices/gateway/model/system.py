"""The whole of it: both units and the link between them, as CANopen and the surroundings see it."""

from collections.abc import Mapping
from math import inf
from typing import Any

from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.buffers import Buffer
from canopen_twins.devices.gateway.model.canopen_side import Sent
from canopen_twins.devices.gateway.model.configuration import Dictionary, built, init_parts
from canopen_twins.devices.gateway.model.engine import Engine
from canopen_twins.devices.gateway.model.gateway import Gateway
from canopen_twins.devices.gateway.model.governor import Governor
from canopen_twins.devices.gateway.model.parameters import Unit
from canopen_twins.devices.gateway.model.settled import Settled
from canopen_twins.devices.gateway.model.state import GatewayState, MasterCommand
from canopen_twins.devices.gateway.model.timing import NEVER, microseconds
from canopen_twins.devices.gateway.model.unit import Options, Surroundings, Tables

ERROR_2005 = 0x2005


class System:
    """Both machines and the link; commands act at once, `step` lets time pass, `outbox` is news."""

    def __init__(
        self, tables: Tables, options: Options | None = None, engine: Engine | None = None
    ) -> None:
        """Both units are off; the engine is as it is, or a new one that stands."""
        around = Surroundings(tables, options or Options())
        self.link = around.link
        self.governor, self.gateway = Governor(around, engine or Engine()), Gateway(around)
        self._time, self._scaling = around.time, tables.scaling
        self._units: tuple[Governor | Gateway, ...] = (self.governor, self.gateway)
        self._to_gateway = self.link.to[Unit.GATEWAY]
        self._to_governor = self.link.to[Unit.GOVERNOR]
        self.settled = Settled(self.governor, self.gateway, self.link, self._time)
        """Knows whether all is at rest; then it sends the TPDOs, if somebody asks for them."""

    def configure(self, content: Mapping[str, Mapping[Any, Any]]) -> None:
        """Deliver both units with these parameters, by number or name; acts at their next reset.

        Raises:
            ValueError: not `gateway` or `governor`, or a parameter that is refused; nothing is
                changed then.
        """
        units = {each.which.value: each for each in self._units}
        for name, values in content.items():
            if name not in units or not isinstance(values, Mapping):
                raise ValueError(f"{name!r} is not 'gateway' or 'governor' with parameters")
        checked = {name: units[name].desk.checked(values) for name, values in content.items()}
        for name, delivered in checked.items():
            units[name].desk.deliver(delivered)

    @property
    def kept(self) -> dict[str, Any]:
        """What both units keep without power, as values for a file."""
        return {each.which.value: each.desk.kept for each in self._units}

    def restore(self, values: Mapping[str, Any]) -> None:
        """Begin with what was kept; acts at the next reset.

        Raises:
            ValueError: something in it is not what was kept.
        """
        for unit in self._units:
            unit.desk.restore(values.get(unit.which.value, {}))

    def power_on(self) -> None:
        """Switch both units on."""
        for unit in self._units:
            unit.reset()

    def power_off(self) -> None:
        """Switch both units off."""
        for unit in self._units:
            unit.power_off()

    def step(self, dt: float) -> None:
        """Let time pass: a multiple of 125 us, in seconds.

        Raises:
            ValueError: not such a multiple.
        """
        end = self._time.now + microseconds(dt)
        if self.settled.at_rest():
            self.settled.leap(end)
        while (due := self._due) <= end:
            self._time.now = due
            self._act(due)
            if self.settled.leaps():
                self.settled.leap(end)
        self._time.now = end
        self.settled.tell(end)
        self.settled.look()

    @property
    def rest(self) -> float:
        """Seconds in which nothing happens by itself that CANopen could notice.

        A main cycle of the governor and what it hears are noticed when a telegram has come over.
        """
        if self.settled.leaps():
            due = self.settled.due
        else:
            hidden = min(self.governor.due, self._to_governor.due)
            due = min(self.gateway.due, self._to_gateway.due, hidden + self._to_gateway.delay)
        return (due - self._time.now) / 1_000_000 if due < NEVER else inf

    @property
    def now(self) -> int:
        """Microseconds that have passed."""
        return self._time.now

    @property
    def _due(self) -> int:
        link = self._to_gateway.due, self._to_governor.due
        return min(*link, self.governor.due, self.gateway.due)

    def _act(self, now: int) -> None:
        while self._to_gateway.due == now:  # a main cycle finds all that has arrived
            self.gateway.receive(self._to_gateway.arrive())
        while self._to_governor.due == now:
            self.governor.receive(self._to_governor.arrive())
        if self.settled.at_rest():  # which what has arrived may end
            self.settled.tell(now)
        for unit in self._units:
            if unit.due == now:
                unit.act()
        self.settled.at_rest()  # and what is missed

    @property
    def state(self) -> GatewayState:
        """The CANopen state machine; Undefined as long as the gateway's programme does not run."""
        running = self.gateway.programme
        return GatewayState.UNDEFINED if running is None else running.state

    @property
    def listening(self) -> bool:
        """Whether NMT is heard: a communicating state, and no fault of the CANopen bus."""
        running = self.gateway.programme
        return running is not None and running.canopen.listening

    @property
    def outbox(self) -> list[Sent]:
        """What the gateway has sent, oldest first; cleared by whoever puts it on the bus."""
        return self.gateway.plug.outbox

    @property
    def dictionary(self) -> Dictionary | None:
        """The configured part of the object dictionary; None before it was created."""
        running = self.gateway.programme
        outputs = None if running is None else running.canopen.outputs
        return None if outputs is None else outputs.dictionary

    @property
    def planned(self) -> Dictionary:
        """The same for the parameters as saved, whether the gateway would accept it or not."""
        gateway, governor = (
            unit.parameters_of_next_start for unit in (self.gateway, self.governor)
        )
        return built(init_parts(governor, self._scaling, self.governor.cycle), gateway)

    def value(self, index: int, sub: int) -> int:
        """A word of 2000h to 2005h."""
        running = self.gateway.programme
        if running is None:
            return 0
        if index == ERROR_2005:
            return int(running.errors.word)
        outputs = running.canopen.outputs
        return 0 if outputs is None else outputs.value(index, sub)

    @property
    def error_register(self) -> int:
        """Object 1001h (A-07)."""
        running = self.gateway.programme
        if running is None:
            return 0
        return errors.error_register(self.gateway.memory.present, running.errors.word)

    def command(self, command: MasterCommand) -> None:
        """An NMT command of the master that concerns the gateway."""
        if self.gateway.programme is not None:
            self.gateway.programme.command(command)

    def receive_rpdo(self, number: int, words: tuple[int, ...]) -> None:
        """An RPDO 1..4 of the master, as whole words."""
        if self.gateway.programme is not None:
            self.gateway.programme.receive_rpdo(number, words)

    def partner_heartbeat(self) -> None:
        """A heartbeat or boot-up message of node 428."""
        if self.gateway.programme is not None:
            self.gateway.programme.partner_heartbeat()

    def overflow(self, buffer: Buffer) -> None:
        """Let a buffer of the gateway overflow; it is cleared at once."""
        if self.gateway.programme is not None:
            self.gateway.programme.overflow(buffer)
