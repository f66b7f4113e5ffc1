"""The parts of the charger, how they act on each other, and how time passes through them."""

from canopen_twins.devices.charger.model.bars import CLEAN, Dirt
from canopen_twins.devices.charger.model.charging import Charging
from canopen_twins.devices.charger.model.discharging import Discharging
from canopen_twins.devices.charger.model.hours import Hours
from canopen_twins.devices.charger.model.messages import Catalogue, Messages, Situation
from canopen_twins.devices.charger.model.parameters import Parameter, Parameters
from canopen_twins.devices.charger.model.release import Release, Source, State
from canopen_twins.devices.charger.model.sparks import Sparks
from canopen_twins.devices.charger.model.surroundings import Feed, Surroundings, feed
from canopen_twins.devices.charger.model.thermal import Derating, Heating, losses
from canopen_twins.devices.charger.model.ticks import TICK, whole_ticks
from canopen_twins.devices.charger.model.types import Build


class Machine:
    """What there is and how it runs; `Charger` adds what can be done to it."""

    def __init__(
        self, build: Build, parameters: Parameters, catalogue: Catalogue, sparks: Sparks
    ) -> None:
        self.build, self.parameters = build, parameters
        self.now = 0  # ticks
        self.surroundings = Surroundings()
        self.release = Release()
        self.charging = Charging(build.kind, parameters, sparks)
        self.discharging = Discharging(build.kind, parameters)
        self.heating = Heating(discharging=build.discharges)
        self.derating = Derating(build.kind)
        self.messages = Messages(catalogue)
        self.hours = Hours()
        self._touched = True  # something was done since the last tick, or came of it
        self._next = 0  # tick at which something changes by itself, unless it is touched before

    @property
    def charging_active(self) -> bool:
        """High voltage at the charging terminal, from the start of the ramp (A-44)."""
        return self.release.state is State.ON

    @property
    def discharging_active(self) -> bool:
        """High voltage at the discharging terminals (2002h:27h, A-43)."""
        values = self.parameters
        return (
            self.build.discharges
            and self.release.state is not State.FAULT
            and self.surroundings.hardware_release_discharging
            and values[Parameter.MODE_DISCHARGING] == 1
            and (self.release.software or not values[Parameter.SOFTWARE_RELEASE_DISCHARGING])
        )

    @property
    def enabled(self) -> Source:
        """The sources that may give and take the software release (2002h:02h)."""
        return Source(self.parameters[Parameter.RELEASE_MODE])

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
            limiter=None if output.ramping(self.now) else output.limiter,
            limiter_warning=values[Parameter.LIMITER_WARNING] == 1,
            pollution=self.charging.pollution,
            dirt=self.dirt,
            discharging_limited=self.discharging.now.limited,
        )

    @property
    def rest(self) -> float:
        """Seconds until the next thing happens by itself; 0 while something moves."""
        quiet = self._quiet
        return quiet * TICK if quiet > 1 else 0.0

    def step(self, dt: float) -> None:
        """Let `dt` seconds pass.

        Raises:
            ValueError: `dt` is not a whole multiple of 10 ms.
        """
        remaining = whole_ticks(dt)
        while remaining > 0:
            ticks = max(1, min(remaining, self._quiet - 1))  # what happens has a tick of its own
            self._advance(ticks)
            remaining -= ticks

    @property
    def _quiet(self) -> int:
        """Ticks until something changes by itself."""
        return 1 if self._touched else self._next - self.now

    def _look_ahead(self) -> int:
        """The same, worked out anew; it holds until then, as long as nobody acts."""
        now, charging, discharging = self.now, self.charging_active, self.discharging_active
        return min(
            self.release.quiet(now, self.parameters[Parameter.RELEASE_TIMEOUT]),
            self.charging.quiet(now, charging),
            self.discharging.quiet(discharging),
            self.heating.quiet(now),
            self.derating.quiet(now, self.heating.at(now), self.supply.voltage),
            self.messages.quiet(now),
            self.hours.quiet(charging, discharging),
        )

    def _advance(self, ticks: int) -> None:
        before = self._state
        self.now += ticks
        self._obey()
        self._drive(ticks)
        self._warm()
        self.hours.add(ticks, self.charging_active, self.discharging_active)
        self.messages.judge(self.now, self.situation)
        self._react()
        self._touched = self._state != before
        if not self._touched:
            self._next = self.now + self._look_ahead()

    def _obey(self) -> None:
        """Timeout and analog setpoint; keys and masters have had their say before."""
        values = self.parameters
        self.release.expire(self.now, values[Parameter.RELEASE_TIMEOUT])
        level = self.surroundings.analog if self.charging.analog else 0.0
        self.release.follow(level if Source.ANALOG in self.enabled else None, self.now)

    def _drive(self, ticks: int) -> None:
        if self.charging_active:
            self.charging.drive(self.now, ticks, self.surroundings, self.derating.charging)
        else:
            self.charging.idle(self.now, ticks)
        if self.discharging_active:
            self.discharging.drive(ticks, self.surroundings, self.derating.discharging)
        elif self.build.discharges:
            self.discharging.idle(self.surroundings)

    def _warm(self) -> None:
        supply, around = self.supply, self.surroundings
        delivered = self.charging.output.power, self.discharging.now.power
        lost = losses(supply.power, *delivered)
        self.heating.lead(self.now, lost, around.ambient, around.heat)
        self.derating.review(self.now, self.heating.at(self.now), supply.voltage)

    def _react(self) -> None:
        """An error that trips switches off and blocks until it is cleared (A-48)."""
        (self.release.trip if self.messages.tripped else self.release.clear)()

    @property
    def _state(self) -> object:
        """What the next tick starts from; equal before and after a tick: it has settled."""
        derating = self.derating
        powers = derating.charging, derating.discharging
        return self.release.state, self.charging.output.voltage, powers
