"""Both units and the engine at rest: nothing moves but counters, and main cycles pass in leaps.

They have come to rest when within a second nothing that engine and governor compute has moved so
that anybody could see it. From then on it stays as it is, until something else is different: what
the units are told, what surrounds them, what is wrong. Until then every telegram says what it has
said before, and only those that become TPDOs are noticed.
"""

from collections.abc import Callable, Sequence
from typing import Any

from canopen_twins.devices.gateway.model import (
    canopen_side,
    engine,
    heinzmann_can,
    inputs,
    speed_governor,
    unit,
)
from canopen_twins.devices.gateway.model import gateway as gateway_unit
from canopen_twins.devices.gateway.model import governor as governor_unit
from canopen_twins.devices.gateway.model.canopen_side import TpdoFrame
from canopen_twins.devices.gateway.model.gateway import Gateway, GatewayProgramme
from canopen_twins.devices.gateway.model.governor import Governor, GovernorProgramme
from canopen_twins.devices.gateway.model.heinzmann_can import Link
from canopen_twins.devices.gateway.model.parameters import Unit
from canopen_twins.devices.gateway.model.timing import MILLISECOND, NEVER, Time

UNSEEN = 1e-9  # rpm, K, bar, or of full scale
SECOND = 1000 * MILLISECOND  # us
LONGEST_DELAY = 10 * MILLISECOND  # of a telegram, so that it has come before the next is sent

Parts = Sequence[tuple[Callable[[Any], Any], object]]
"""Objects, each with what is read of it."""


class Settled:
    """Watches both units, and lets time pass in leaps while they are at rest."""

    def __init__(self, governor: Governor, gateway: Gateway, link: Link, time: Time) -> None:
        self._governor, self._gateway, self._link, self._time = governor, gateway, link, time
        self._to_gateway, self._to_governor = link.to[Unit.GATEWAY], link.to[Unit.GOVERNOR]
        self._looked = 0  # when, us
        self._parts: Parts = ()
        self._held: list[Any] = []
        self._motion: list[Any] = []
        self._resting: tuple[GovernorProgramme, GatewayProgramme] | None = None
        self._waits = False  # for what may be missed
        self.is_asked = False
        """Whether somebody asks for TPDOs by `tell` when they are due."""
        self._frames: dict[int, TpdoFrame] = {}  # by number, as long as it is at rest
        self._untaken: set[int] = set()  # those that have not come since
        self._cycle = 0  # main cycle of the governor with the next of them
        self._numbers: list[int] = []  # which those are
        self.next_tpdos = NEVER
        """When the next of them are due, us; NEVER without rest."""

    def at_rest(self) -> bool:
        """Whether nothing moves; anything that is different from the last look ends that."""
        if self._resting is None:
            return False
        if self._held == [read(part) for read, part in self._parts]:
            return True
        governor, gateway = self._resting
        self.tell(self._time.now)
        governor.control.at_rest = gateway.canopen.at_rest = False
        self._resting, self._parts, self.next_tpdos = None, (), NEVER
        return False

    def look(self) -> None:
        """See once a second whether all has come to rest; not while it is."""
        if self._resting is not None or self._time.now - self._looked < SECOND:
            return
        self._looked = self._time.now
        held, motion, known = self._held, self._motion, bool(self._parts)
        governor, gateway = self._governor.programme, self._gateway.programme
        if governor is None or gateway is None or not self._is_quiet(governor, gateway):
            self._parts = ()
            return
        moving = _moving(governor)
        self._parts = [*self._still(governor, gateway)]
        self._held = [read(part) for read, part in self._parts]
        self._motion = [number for read, part in moving for number in read(part)]
        if known and held == self._held and _is_still(motion, self._motion):
            governor.control.at_rest = True
            self._parts = [*self._parts, *moving]
            self._held = [read(part) for read, part in self._parts]
            self._resting = governor, gateway
            self._waits = governor.inputs.watches or gateway.canopen.watches
            gateway.canopen.at_rest = True
            self._begin_tpdos(governor, gateway)

    def _is_quiet(self, governor: GovernorProgramme, gateway: GatewayProgramme) -> bool:
        """Whether the next main cycles do again what the last ones have done."""
        directions = self._to_gateway, self._to_governor
        passing = all(not (each.cut or each.drop) for each in directions)
        quick = all(each.delay <= LONGEST_DELAY for each in directions)
        return passing and quick and governor.is_steady and gateway.is_steady

    def _still(self, governor: GovernorProgramme, gateway: GatewayProgramme) -> Parts:
        """What main cycles depend on, but for what moves."""
        units = self._governor, self._gateway
        return [
            (engine.HELD, self._governor.engine),
            (speed_governor.HELD, governor.control.speed),
            (speed_governor.OPERATION, self._governor.operation),
            (governor_unit.HELD, governor),
            *((inputs.HELD, rpdo) for rpdo in governor.inputs.rpdos.values()),
            (gateway_unit.HELD, gateway),
            (canopen_side.HELD, gateway.canopen),
            *((unit.HELD, each) for each in units),
            *((heinzmann_can.WIRING, each.wiring) for each in units),
            *((heinzmann_can.DIRECTION, each) for each in self._link.to.values()),
            (heinzmann_can.LINK, self._link),
        ]

    # Leaps: to be taken while at rest

    @property
    def _is_underway(self) -> bool:
        return self._to_gateway.underway or self._to_governor.underway

    def leaps(self) -> bool:
        """Whether it is at rest, and no telegram is on its way."""
        return not self._is_underway and self.at_rest()

    @property
    def due(self) -> int:
        """When a step is wanted, us."""
        return self._missed if self.repeats else min(self.next_tpdos, self._missed)

    @property
    def repeats(self) -> bool:
        """Whether TPDOs that are asked for bring nothing new, and need no step."""
        return self.is_asked and not self._untaken

    @property
    def _missed(self) -> int:
        """When something is missed that has not come, us."""
        if self._resting is None or not self._waits:
            return NEVER
        governor, gateway = self._resting
        return min(self._governor.after(governor.patience), self._gateway.after(gateway.patience))

    def leap(self, end: int) -> None:
        """Let time pass up to a moment, us, or as far before as nothing is underway or missed."""
        if self._resting is None or self._is_underway:
            return
        governor, gateway = self._resting
        end = min(end, self._missed - 1)
        while True:
            ticks, last = self._governor.cycles_until(end)
            others, latest = self._gateway.cycles_until(end)
            told = latest - gateway.cycles_since_alive(others) * self._gateway.cycle
            if ticks and last + self._to_gateway.delay > end:
                end = last - 1
            elif others and told + self._to_governor.delay > end:
                end = told - 1
            else:
                break
        self.tell(end)
        for number in governor.tpdos_among(ticks):
            self._take(gateway, number)
        governor.leap(ticks, last, told + self._to_governor.delay)
        gateway.leap(others, last + self._to_gateway.delay if ticks else None)
        self._governor.due += ticks * self._governor.cycle
        self._gateway.due += others * self._gateway.cycle

    # TPDOs: while at rest they are sent by `tell` alone

    def tell(self, until: int) -> None:
        """Send the TPDOs that are due up to a moment, us, and have not been sent."""
        if self._resting is None:
            return
        governor, gateway = self._resting
        while self.next_tpdos <= until:
            for number in self._numbers:
                gateway.canopen.send_tpdo(self._take(gateway, number))
            self._await_tpdos(governor, self._cycle)

    def _begin_tpdos(self, governor: GovernorProgramme, gateway: GatewayProgramme) -> None:
        """Those that are underway are among them."""
        self._frames = {n: TpdoFrame(n, words) for n, words in governor.told.items()}
        self._untaken = set(self._frames)
        self.next_tpdos = NEVER
        if gateway.canopen.operational:
            since = self._time.now - self._to_gateway.delay - self._governor.due
            last = governor.served + since // self._governor.cycle + 1
            self._await_tpdos(governor, last)

    def _await_tpdos(self, governor: GovernorProgramme, cycle: int) -> None:
        """After a main cycle."""
        self._cycle, self._numbers = governor.tpdos_after(cycle)
        due = self._governor.after(self._cycle - governor.served)
        self.next_tpdos = due + self._to_gateway.delay

    def _take(self, gateway: GatewayProgramme, number: int) -> TpdoFrame:
        """The values of a TPDO that has come are those of the dictionary."""
        frame = self._frames[number]
        if number in self._untaken:
            self._untaken.remove(number)
            gateway.canopen.take_tpdo(*frame)
        return frame


def _moving(governor: GovernorProgramme) -> Parts:
    control = governor.control
    return [(engine.MOTION, control.engine), (speed_governor.MOTION, control.speed)]


def _is_still(before: Sequence[Any], after: Sequence[Any]) -> bool:
    moved = (abs((a or 0.0) - (b or 0.0)) for a, b in zip(before, after, strict=True))
    return all(way <= UNSEEN for way in moved)
