"""A device on a wire: the path of a frame, power and time, and every boot."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from math import inf
from typing import NamedTuple

from canopen import ObjectDictionary

from canopen_twins.bus.clock import MICROSECONDS, Action, Clock, Scope, Timer, microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.wire import Outbox, Wire, through
from canopen_twins.device.device import Device
from canopen_twins.device.faults import Faults
from canopen_twins.device.stack import Stack
from canopen_twins.slave.emcy import EmcyLog
from canopen_twins.slave.nmt import Reset
from canopen_twins.slave.object import COMMUNICATION_AREA
from canopen_twins.slave.profile import Profile
from canopen_twins.slave.service import Handler, State
from canopen_twins.slave.slave import Slave

EVERYTHING = range(0x1000, 0x10000)


class Ahead(NamedTuple):
    """What is ready of the next boot, as long as nothing happens to the device."""

    dictionary: ObjectDictionary
    node_id: int
    profile: Profile
    slave: Slave | None = None


class Node:
    """A device with power on or off; it needs a clock and somebody who empties the outbox."""

    def __init__(
        self, device: Device, clock: Clock, outbox: Outbox | None = None, name: str = "node"
    ) -> None:
        self.device = device
        self.clock = clock
        self.wire = Wire(clock, outbox, name)
        self.wire.bit_rate = lambda: self.device.bit_rate if self.powered else None
        self.faults = Faults(device.faults)  # a segment adds those around it
        self.powered = False
        self._stack: Stack | None = None  # none: silent, whatever the reason
        self._before: Slave | None = None
        self._booting: list[Timer] = []  # the end of the boot time, and what is done ahead of it
        self._ahead: Ahead | None = None
        self._afresh = True  # the next boot is one of the application, not of communication alone
        self.log = EmcyLog()
        self.listeners: list[Callable[[State], None]] = [device.on_state]  # hear of every state
        self._cycle = microseconds(device.cycle)
        self._counts_frames = type(device).on_frame is not Device.on_frame
        self._stepped = clock.ticks
        self._changed = clock.ticks
        self._wake: float = inf
        self._timer: Timer | None = None

    @property
    def slave(self) -> Slave | None:
        """The dictionary in force, none while the node is silent."""
        return None if self._stack is None else self._stack.slave

    @property
    def dictionary(self) -> ObjectDictionary:
        """The one in force, or the one to boot with; for whoever only looks."""
        stack = self._stack
        return self.device.dictionary() if stack is None else stack.slave.object_dictionary

    @property
    def state(self) -> State:
        """The NMT state; Initialisation also means silence, whatever its reason."""
        return State.INITIALISING if self._stack is None else self._stack.state

    @property
    def booting(self) -> bool:
        """Whether it is silent because it takes its time to boot."""
        return bool(self._booting)

    @property
    def node_id(self) -> int:
        """The node id in force, or the one to boot with."""
        return self.device.node_id if self._stack is None else self._stack.slave.node_id

    @property
    def changed_at(self) -> int:
        """Microsecond at which the device may have changed last: by a step, an act, a refresh of
        what is measured or its noise."""
        stack = self._stack
        noisy = stack is not None and stack.measurement is not None and not stack.measurement.held
        return self.clock.ticks if noisy else self._changed

    def power_on(self) -> None:
        """Switch the supply on; without effect if it is.

        Raises:
            UserError: something is wrong with the class of the device.
        """
        if self.powered:
            return
        self.device.complete()
        self._catch_up()
        self.powered = True
        self._stepped = self.clock.ticks
        self.device.power_on()
        self.faults.renew(self.device.faults)
        self._settle()

    def power_off(self) -> None:
        """Switch the supply off: what is not in the memory is lost."""
        if not self.powered:
            return
        self._catch_up()
        self._fall_silent()
        self._afresh = True
        self.device.power_off()
        self.powered = False
        self._changed = self.clock.ticks
        self._disarm()

    def look(self) -> Device:
        """The device as it is at this moment: time has passed for it, and nothing is sent."""
        self._catch_up()
        return self.device

    def receive(self, frame: Frame) -> None:
        """Take a frame from the bus; what the node sends is in the outbox afterwards."""
        stack = self._stack
        if stack is None or frame.extended:
            return
        if filters := self.wire.incoming:
            if not stack.slave.shut:
                through(filters, frame, self._take)
        elif (handlers := stack.routes.get((frame.can_id, frame.remote))) and not stack.slave.shut:
            looked = self._act_on(stack, frame, handlers)
            if self.wire.outgoing or not looked:
                self._settle()

    def _take(self, frame: Frame) -> None:
        """What the filters have let through, now or later."""
        stack = self._stack
        if stack is None or stack.slave.shut:
            return
        if handlers := stack.routes.get((frame.can_id, frame.remote)):
            self._act_on(stack, frame, handlers)
            self._settle()  # whatever the filters have done

    def _act_on(self, stack: Stack, frame: Frame, handlers: Sequence[Handler]) -> bool:
        """Whether that was no more than a look: then there is nothing to tell."""
        untold = self._catch_up()
        looked = not (untold or self._counts_frames or stack.measurement)
        stack.slave.active_at = self.clock.ticks
        if self._counts_frames:
            self.device.on_frame()
        for handle in handlers:
            if untold and self._stack is not None:
                stack.tell()
            if not handle(frame):
                looked = False
            untold = not looked
        return looked

    def _on_time(self, action: Action) -> None:
        """A timer of a service acts as a frame does."""
        self._catch_up()
        action()
        self._settle()

    def settle(self) -> None:
        """Let news go out of what has been done to the device by hand."""
        with self.acting():
            pass

    @contextmanager
    def acting(self) -> Iterator[Device]:
        """Act on the device at this moment: time has passed before, news goes out after."""
        yield self.look()
        if self.powered:
            self._settle()

    def _catch_up(self) -> bool:
        """Let the time pass that has gone by; whether that was a step that may bring news."""
        stack, stepped = self._stack, False
        if stack is not None and stack.measurement is not None:
            due = stack.measurement.due(self.clock.ticks)
            if due is not None:
                stepped = self._step_to(due)
                stack.measurement.refresh(due)
                self._changed = self.clock.ticks
        if self.clock.ticks - self._stepped >= self._cycle:
            stepped = self._step_to(self.clock.ticks)
        if not (stepped and self._stepped >= self._wake):  # until then it rests
            return False
        self._ahead = None
        return True

    def _step_to(self, tick: int) -> bool:
        elapsed = tick - self._stepped
        whole = elapsed - elapsed % self._cycle
        if not whole:
            return False
        self._stepped += whole
        self._changed = self.clock.ticks
        step = self.device.step if self.powered else self.device.step_unpowered
        step(whole / MICROSECONDS)
        return True

    def _settle(self) -> None:
        self._changed = self.clock.ticks
        self._ahead = None
        self._follow()
        if self._stack is not None:
            self._stack.publish()
        if self._wake - self._stepped > self._cycle:  # it rests: does it still?
            self._arm()

    def _tick(self) -> None:
        self._catch_up()
        self._settle()
        while self._is_alone:
            self.clock.go_on(self._stepped + self._cycle)
            self._catch_up()
            self._settle()
        self._arm()

    @property
    def _is_alone(self) -> bool:
        """Whether the next cycle of a device that moves is what comes next: it needs no timer."""
        if self.device.rest or self.wire.outbox:
            return False
        return self.clock.is_free(self._stepped + self._cycle)

    def _arm(self) -> None:
        rest, stack = self.device.rest * MICROSECONDS, self._stack
        if stack is not None and stack.measurement is not None:
            rest = min(rest, stack.measurement.next_refresh - self._stepped)
        if rest < self._cycle:
            rest = self._cycle
        elif rest != inf:
            rest -= rest % self._cycle
        wake = self._stepped + rest
        if wake == self._wake:
            return
        if self._timer is not None:
            self._timer.cancel()
        self._wake = wake
        self._timer = None if wake == inf else self.clock.at_tick(int(wake), self._tick)

    def _disarm(self) -> None:
        self._wake = inf
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _follow(self) -> None:
        """Boot, fall silent or reset as the device and the NMT master want it."""
        stack = self._stack
        if stack is None:
            if self.device.online:
                self._start()
            else:
                self._stop_booting()
        elif not self.device.online:
            self._fall_silent()
            self._afresh = True
        elif stack.reset is not None:
            self._reset(stack.reset)
        else:
            stack.follow()

    def _reset(self, reset: Reset) -> None:
        self._fall_silent()
        self._afresh = reset is Reset.NODE
        if reset is Reset.NODE:
            self.device.reset_node()
        else:
            self.device.reset_communication()
        if self.device.online:
            self._start()

    def _start(self) -> None:
        """Boot when the boot time is over."""
        if self._booting:
            return
        if boot_time := self.device.timing.boot_time:
            end = self.clock.ticks + microseconds(boot_time)
            parts = (self._read_ahead, self._make_ahead, self._end_booting)
            self._booting = [
                self.clock.at_tick(end - left, part)
                for left, part in zip((2, 1, 0), parts, strict=True)
            ]
        else:
            self._boot()

    def _read_ahead(self) -> None:
        """A boot takes ms of real time: frames for others may be answered between its parts."""
        device = self.device
        self._ahead = Ahead(device.dictionary(), device.node_id, device.profile)

    def _make_ahead(self) -> None:
        if self._ahead is not None:
            self._ahead = self._ahead._replace(slave=self._slave(*self._ahead[:3]))

    def _end_booting(self) -> None:
        self._booting = []
        self._catch_up()
        if self.device.online:
            self._boot()
        self._settle()

    def _stop_booting(self) -> None:
        for timer in self._booting:
            timer.cancel()
        self._booting, self._ahead = [], None

    def _slave(self, dictionary: ObjectDictionary, node_id: int, profile: Profile) -> Slave:
        slave = Slave(dictionary, node_id, self.wire, Scope(self.clock, self._on_time), profile)
        slave.stepped = lambda: self._stepped
        return slave

    def _boot(self) -> None:
        """A fresh slave from the EDS and the stored parameters."""
        device, slave = self.device, self._ahead and self._ahead.slave
        if slave is None:
            slave = self._slave(device.dictionary(), device.node_id, device.profile)
        slave.active_at = self.clock.ticks
        if self._afresh:
            self.log = EmcyLog()
        elif self._before is not None:
            slave.keep_application(self._before)
        area = EVERYTHING if self._afresh else COMMUNICATION_AREA
        self._stack = Stack(slave, device, self.log, self.listeners, area)
        self._stack.boot_up()

    def _fall_silent(self) -> None:
        self._stop_booting()
        if self._stack is not None:
            self._before = self._stack.slave
            self._stack.close()
            self.wire.events.add_state(State.INITIALISING)
            self.wire.listen(())
            self._stack = None


def wait_for_boot(nodes: Sequence[Node], advance: Callable[[float], None]) -> bool:
    """Let time pass, by what takes seconds of it, until all have booted; whether they have.

    A device that has not booted after a minute never will with the settings it has.
    """
    for _ in range(600):
        if all(node.slave is not None for node in nodes):
            return True
        advance(0.1)
    return False
