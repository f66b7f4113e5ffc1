"""What a control unit keeps without power, as values for a file (9.2)."""

from collections.abc import Mapping
from enum import Enum
from math import inf
from typing import Any

from canopen_twins.devices.gateway.model import errors
from canopen_twins.devices.gateway.model.canopen_errors import error_register
from canopen_twins.devices.gateway.model.canopen_side import Message
from canopen_twins.devices.gateway.model.configuration import init_parts
from canopen_twins.devices.gateway.model.dictionary import Dictionary, built
from canopen_twins.devices.gateway.model.errors import COUNTERS, MOST
from canopen_twins.devices.gateway.model.machines import Gateway, Governor, Tables
from canopen_twins.devices.gateway.model.options import Options
from canopen_twins.devices.gateway.model.parameters import Unit
from canopen_twins.devices.gateway.model.state import MasterCommand, State, Trouble
from canopen_twins.devices.gateway.model.timing import NEVER, microseconds
from canopen_twins.devices.gateway.model.unit import Surroundings

LAST_IDENTIFIER = 3851


def kept(unit: Governor | Gateway) -> dict[str, Any]:
    """Saved parameters, counters of the permanent error memory, exception, last identification."""
    counts = unit.memory.counts
    return {
        "parameters": {str(number): value for number, value in unit.store.saved.items()},
        "errors": {str(number + COUNTERS): counts[number] for number in sorted(counts)},
        "exception": list(unit.exception),
        "last identifier": unit.shown[LAST_IDENTIFIER],
    }


def restore(unit: Governor | Gateway, values: Mapping[str, Any]) -> None:
    """Begin with what was kept; what is not given stays as it is.

    Raises:
        ValueError: something in it is not what this unit keeps.
    """
    try:
        parameters = {int(number): each for number, each in values.get("parameters", {}).items()}
        unit.desk.deliver(unit.desk.checked(parameters))
        for number, count in values.get("errors", {}).items():
            unit.memory.counts[int(number) - COUNTERS] = min(max(0, int(count)), MOST)
        first, second, third, fourth = values.get("exception", unit.exception)
        unit.exception = (int(first), int(second), int(third), int(fourth))
        unit.desk.show(LAST_IDENTIFIER, values.get("last identifier", 0))
    except (AttributeError, TypeError) as reason:
        raise ValueError(f"{unit.which.value}: not what was kept: {reason}") from None


class Buffer(Enum):
    """Buffers of the gateway that can overflow (7.2.1, 7.2.2, A-09)."""

    CAN1_RECEIVE = "CANopen data from the governor"
    CAN2_RECEIVE = "frames from the CANopen bus"
    SDO_TRANSMIT = "SDO answers"


OVERFLOW: Mapping[Buffer, tuple[int, Trouble]] = {
    Buffer.CAN1_RECEIVE: (errors.CAN_COMM_1, Trouble.ABORT),
    Buffer.CAN2_RECEIVE: (errors.CAN_COMM_2, Trouble.ABORT),
    Buffer.SDO_TRANSMIT: (errors.CAN_COMM_2, Trouble.SDO_OVERFLOW),
}
ERROR_2005 = 0x2005


class System:
    """Both machines and the link; commands act at once, `step` lets time pass, `outbox` is news."""

    def __init__(self, tables: Tables, options: Options | None = None) -> None:
        options = options or Options()
        around = Surroundings(tables.catalogue)
        self.link = around.link
        self.governor = Governor(around, tables, options)
        self.gateway = Gateway(around, tables, options)
        self._time, self._scaling = around.time, tables.scaling
        self._units: tuple[Governor | Gateway, ...] = (self.governor, self.gateway)
        self._to_gateway = self.link.to[Unit.GATEWAY]
        self._to_governor = self.link.to[Unit.GOVERNOR]

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
        return {each.which.value: kept(each) for each in self._units}

    def restore(self, values: Mapping[str, Any]) -> None:
        """Begin with what was kept; acts at the next reset.

        Raises:
            ValueError: something in it is not what was kept.
        """
        for unit in self._units:
            restore(unit, values.get(unit.which.value, {}))

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
        while (due := self._due) <= end:
            self._time.now = due
            self._act(due)
        self._time.now = end

    @property
    def rest(self) -> float:
        """Seconds in which nothing happens by itself that CANopen could notice.

        A main cycle of the governor and what it hears are noticed when a telegram has come over.
        """
        hidden = min(self.governor.due, self._to_governor.due)
        due = min(self.gateway.due, self._to_gateway.due, hidden + self._to_gateway.delay)
        return (due - self._time.now) / 1_000_000 if due < NEVER else inf

    @property
    def _due(self) -> int:
        link = self._to_gateway.due, self._to_governor.due
        return min(*link, self.governor.due, self.gateway.due)

    def _act(self, now: int) -> None:
        while self._to_gateway.due == now:  # a main cycle finds all that has arrived
            self.gateway.receive(self._to_gateway.arrive())
        while self._to_governor.due == now:
            self.governor.receive(self._to_governor.arrive())
        for unit in self._units:
            if unit.due == now:
                unit.act()

    @property
    def state(self) -> State:
        """The CANopen state machine; Undefined as long as the gateway's programme does not run."""
        running = self.gateway.programme
        return State.UNDEFINED if running is None else running.state

    @property
    def listening(self) -> bool:
        """Whether NMT is heard: a communicating state, and no fault of the CANopen bus."""
        running = self.gateway.programme
        return running is not None and running.canopen.listening

    @property
    def outbox(self) -> list[Message]:
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
        gateway, governor = self.gateway.store.after_reset, self.governor.store.after_reset
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
        return error_register(self.gateway.memory.present, running.errors.word)

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
            self.gateway.programme.canopen.partner_heartbeat()

    def overflow(self, buffer: Buffer) -> None:
        """Let a buffer of the gateway overflow; it is cleared at once."""
        if self.gateway.programme is not None:
            self.gateway.programme.overflow(*OVERFLOW[buffer])
