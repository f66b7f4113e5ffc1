"""The POWER CHARGER: its parts, what is done to it, and how time passes through them."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from enum import Enum, auto
from typing import Any

from canopen_twins.devices.charger.model.charging import Charging
from canopen_twins.devices.charger.model.discharging import CLEAN, Dirt, Discharge, Discharging
from canopen_twins.devices.charger.model.messages import (
    COUNTERS,
    Catalogue,
    Message,
    Messages,
    Severity,
    Situation,
)
from canopen_twins.devices.charger.model.parameters import Parameter, Parameters
from canopen_twins.devices.charger.model.release import EVERY, Release, ReleaseSource, ReleaseState
from canopen_twins.devices.charger.model.sparks import Sparks
from canopen_twins.devices.charger.model.surroundings import Feed, Surroundings, feed
from canopen_twins.devices.charger.model.thermal import Derating, Heating, losses
from canopen_twins.devices.charger.model.ticks import TICK, Hours, whole_ticks
from canopen_twins.devices.charger.model.types import Build, Quantity, Variant

# /C has no entries for the settings of its discharging: by the letter it just works.
FIXED_IN_C = {
    Parameter.MODE_DISCHARGING: 1,
    Parameter.SOFTWARE_RELEASE_DISCHARGING: 0,
    Parameter.POLLUTION_DETECTION_DISCHARGING: 1,
}


class Key(Enum):
    """The keys of the keypad that matter here."""

    ON = auto()
    OFF = auto()


class Charger:
    """Time passes in `step`; the rest are commands, and what shows how things are.

    Args:
        build: Type and variant.
        values: Every parameter, as stored or as the factory sets it.
        catalogue: The messages that can be reported.
        sparks: The detector, where another reading of the manual is wanted (A-56, A-57).
        timed: The sources whose releases the timeout ends (A-42).
        surroundings: What is around it when it is switched on.
    """

    def __init__(  # noqa: PLR0913 - what is ordered, kept, read and around
        self,
        build: Build,
        values: Mapping[Parameter, int],
        catalogue: Catalogue,
        sparks: Sparks | None = None,
        *,
        timed: ReleaseSource = EVERY,
        surroundings: Surroundings | None = None,
    ) -> None:
        self.build = build
        self.parameters = Parameters(build.kind, values)
        self.now = 0  # ticks
        self.surroundings = surroundings or Surroundings()
        self.release = Release(timed)
        self.charging = Charging(build.kind, self.parameters, sparks or Sparks())
        self.discharging = Discharging(build.kind, self.parameters)
        self.heating = Heating(self.surroundings.ambient, discharging=build.discharges)
        self.derating = Derating(build.kind)
        self.messages = Messages(catalogue)
        self.hours = Hours()
        self._touched = True  # something was done since the last tick, or came of it
        self._next = 0  # tick at which something changes by itself, unless it is touched before
        self._swings = False  # whether that is the discharging alone, as it does again and again
        self._calm: set[Discharge] = set()  # where it was since, and no message had a cause
        self._fixed = FIXED_IN_C if build.entries_of is Variant.C else {}
        self.restart(values)

    @property
    def charging_active(self) -> bool:
        """High voltage at the charging terminal, from the start of the ramp (A-44)."""
        return self.release.state is ReleaseState.ON

    @property
    def limiter(self) -> Quantity | None:
        """What limits the charging (6401h:04h); it falls with the high voltage."""
        return self.charging.output.limiter if self.charging_active else None

    @property
    def discharging_active(self) -> bool:
        """High voltage at the discharging terminals (2002h:27h, A-43)."""
        values = self.parameters
        return (
            self.build.discharges
            and self.release.state is not ReleaseState.FAULT
            and self.surroundings.hardware_release_discharging
            and values[Parameter.MODE_DISCHARGING] == 1
            and (self.release.software or not values[Parameter.SOFTWARE_RELEASE_DISCHARGING])
        )

    @property
    def enabled(self) -> ReleaseSource:
        """The sources that may give and take the software release (2002h:02h)."""
        return ReleaseSource(self.parameters[Parameter.RELEASE_MODE])

    @property
    def dirt(self) -> tuple[Dirt, Dirt]:
        """What a /C has found on its discharging bars (6000h:07h and 08h)."""
        return self.discharging.dirt if self.build.finds_dirt else CLEAN

    @property
    def supply(self) -> Feed:
        """What is drawn from the supply (2001h:01h to 03h)."""
        delivered = self.charging.output.power, self.discharging.now.power
        return feed(self.surroundings.supply_voltage, *delivered)

    @property
    def situation(self) -> Situation:
        """What messages are judged by."""
        output, supply, values = self.charging.output, self.supply, self.parameters
        return Situation(
            kind=self.build.kind,
            supply_voltage=supply.voltage,
            supply_power=supply.power,
            temperatures=self.heating.at(self.now),
            counts=self.charging.sparks.counts,
            sparks_limit=values[Parameter.SPARKS_LIMIT],
            voltage=output.voltage,
            regulator=output.regulator,
            limiter=self.limiter,
            limiter_warning=values[Parameter.LIMITER_WARNING] == 1,
            pollution=self.charging.pollution,
            dirt=self.dirt,
            discharging_limited=self.discharging.now.limited,
        )

    def restart(self, values: Mapping[Parameter, int]) -> None:
        """As after switching on, but for temperatures and hour counters (A-26)."""
        self.release.restart()
        self.messages.restart()
        self.charging.restart()
        self.discharging.restart_calibration()
        self.load({**values, Parameter.KEYBOARD_LOCK: 0})  # 2002h:1Ch
        self.grant(ReleaseSource.AUTOSTART)
        self._react()

    def load(self, values: Mapping[Parameter, int]) -> None:
        """Take over many parameters, stored ones or those of the factory; they act at once."""
        self.parameters.load({**values, **self._fixed})
        self.release.restrict(self.enabled)
        self._touched = True

    def write(self, parameter: Parameter, value: int) -> None:
        """Set one parameter, whose constant limits have been checked.

        Raises:
            OutOfRange: beyond the limit that another parameter sets; nothing has changed.
        """
        self.parameters.write(parameter, value)
        if parameter in AFTER_WRITE:
            AFTER_WRITE[parameter](self)
        self._touched = True

    def grant(self, source: ReleaseSource) -> None:
        """A source gives the software release; without effect if it is not enabled (A-40)."""
        if source in self.enabled:
            self.release.set(source, self.now)
            self._touched = True

    def revoke(self, source: ReleaseSource) -> None:
        """A source takes the software release away, whoever gave it (A-40)."""
        if source in self.enabled:
            self.release.reset()
            self._touched = True

    def press(self, key: Key) -> None:
        """A key of the keypad; without effect while the keyboard is locked (2002h:1Ch)."""
        if not self.parameters[Parameter.KEYBOARD_LOCK]:
            {Key.ON: self.grant, Key.OFF: self.revoke}[key](ReleaseSource.HMI)

    def clear(self, severity: Severity, number: int) -> None:
        """2003h: a message goes if it is active and its cause is gone (A-35)."""
        message = self.messages.find(severity, number)
        if message is None:
            return
        if counter := COUNTERS.get((severity, message.key)):
            self.charging.sparks.reset(counter)
        self.messages.clear(message, self.situation)
        self._react()
        self._touched = True

    def force(self, message: Message) -> None:
        """Report a message for a cause outside the model; it cannot be cleared for now."""
        self.messages.force(message)
        self._react()
        self._touched = True

    def unforce(self, message: Message) -> None:
        """That cause is gone; the message stays until it is cleared."""
        self.messages.unforce(message)

    def spark(self, current: float, rise_time: float = 0.0, late: int = 0) -> None:
        """A spark: the current rises by so many A within so many s; none without high voltage.

        It strikes `late` ms after the present tick.
        """
        if self.charging_active:
            self.charging.spark(self.now, current, rise_time, late)
            self._touched = True

    def surround(self, **changes: Any) -> None:
        """Change the surroundings; the names are those of `Surroundings`."""
        self.surroundings = replace(self.surroundings, **changes)
        self.release.contact(self.surroundings.hardware_release)
        if "storm" in changes:
            self.charging.expect(self.surroundings.storm)
        self._warm()
        self._touched = True

    def inherit(self, former: "Charger") -> None:
        """What outlives the supply goes on: the charge at the terminal, and the heat."""
        self.charging.output.hold(former.charging.output.voltage)
        self.heating.inherit(former.heating.at(former.now), self.now)

    def switch_off(self) -> None:
        """The supply goes, and with it what it feeds."""
        self.release.restart()
        self.charging.idle(self.now, 0, self.surroundings)
        self.discharging.idle(self.surroundings.web)
        self._cool()

    def step_unpowered(self, dt: float) -> None:
        """Let `dt` seconds, whole ticks, pass without supply: it cools, and the load drains it."""
        ticks = whole_ticks(dt)
        self.now += ticks
        self.charging.idle(self.now, ticks, self.surroundings)
        self._cool()

    def _cool(self) -> None:
        none = losses(0.0, 0.0, 0.0)
        self.heating.lead(self.now, none, self.surroundings.ambient, self.surroundings.heat)

    @property
    def rest(self) -> float:
        """Seconds until the next thing happens by itself; 0 while something moves.

        The hour counters run meanwhile.
        """
        quiet = self._quiet
        return quiet * TICK if quiet > 1 else 0.0

    def step(self, dt: float) -> None:
        """Let `dt` seconds pass.

        Raises:
            ValueError: `dt` is not a whole multiple of 10 ms.
        """
        remaining = whole_ticks(dt)
        while remaining > 0:
            ticks = min(remaining, self._quiet - 1)  # what happens has a tick of its own
            if ticks > 0:
                self._coast(ticks)
            else:
                ticks = 1
                self._advance(ticks)
            remaining -= ticks

    @property
    def _quiet(self) -> int:
        """Ticks until something changes by itself."""
        return 1 if self._touched else self._next - self.now

    def _look_ahead(self) -> None:
        """Work out until when nothing changes, as long as nobody acts."""
        now, swing = self.now, self.discharging.quiet(self.discharging_active)
        others = min(
            self.release.quiet(now, self.parameters[Parameter.RELEASE_TIMEOUT]),
            self.charging.quiet(now, self.charging_active),
            self.heating.quiet(now),
            self.derating.quiet(now, self.heating.at(now)),
            self.messages.quiet(now),
        )
        self._next, self._swings = now + min(swing, others), swing < others

    def _coast(self, ticks: int) -> None:
        """Let ticks pass in which nothing changes but what counts them."""
        self.now += ticks
        if self.charging_active:
            self.charging.drive(self.now, ticks, self.surroundings, self.derating.charging)
        discharging = self.discharging_active
        if discharging:
            self.discharging.coast(ticks)
        self.hours.add(ticks, self.charging_active, discharging)

    def _advance(self, ticks: int) -> None:
        before, swings = self._state, self._swings and not self._touched
        self.now += ticks
        if not swings:
            self._calm.clear()
            self._obey()
        self._drive(ticks)
        self._warm()
        self.hours.add(ticks, self.charging_active, self.discharging_active)
        if self.discharging.now not in self._calm:
            self._judge()
        self._touched = self._state != before
        if not self._touched:
            self._look_ahead()

    def _judge(self) -> None:
        self.messages.judge(self.now, self.situation)
        self._react()
        if self.messages.calm:
            self._calm.add(self.discharging.now)

    def _obey(self) -> None:
        """Timeout and analog setpoint; keys and masters have had their say before."""
        values = self.parameters
        self.release.expire(self.now, values[Parameter.RELEASE_TIMEOUT])
        level = self.surroundings.analog if self.charging.analog else 0.0
        self.release.follow(level if ReleaseSource.ANALOG in self.enabled else None, self.now)

    def _drive(self, ticks: int) -> None:
        around = self.surroundings
        if self.charging_active:
            self.charging.drive(self.now, ticks, around, self.derating.charging)
        else:
            self.charging.idle(self.now, ticks, around)
        if self.discharging_active:
            self.discharging.drive(ticks, around.bars, around.web, self.derating.discharging)
        elif self.build.discharges:
            self.discharging.idle(around.web)

    def _warm(self) -> None:
        supply, around = self.supply, self.surroundings
        delivered = self.charging.output.power, self.discharging.now.power
        lost = losses(supply.power, *delivered)
        self.heating.lead(self.now, lost, around.ambient, around.heat)
        self.derating.review(self.now, self.heating.at(self.now), supply.voltage, around.heat)

    def _react(self) -> None:
        """An error that trips switches off and blocks until it is cleared (A-48)."""
        self.release.block(self.messages.tripped)

    @property
    def _state(self) -> object:
        """What the next tick starts from; equal before and after a tick: it has settled."""
        derating = self.derating
        powers = derating.charging, derating.discharging
        return self.release.state, self.charging.output.voltage, powers


AFTER_WRITE: Mapping[Parameter, Callable[[Charger], None]] = {
    Parameter.RELEASE_MODE: lambda charger: charger.release.restrict(charger.enabled),
    Parameter.RELEASE_TIMEOUT: lambda charger: charger.release.rewind(charger.now),
    Parameter.POLLUTION_DETECTION: lambda charger: charger.charging.calibration.restart(),
    Parameter.NOMINAL_RESISTOR: lambda charger: charger.charging.calibration.restart(),
    Parameter.POLLUTION_DETECTION_DISCHARGING: lambda charger: (
        charger.discharging.restart_calibration()
    ),
}
