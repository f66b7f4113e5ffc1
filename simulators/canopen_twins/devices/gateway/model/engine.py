"""Engine with actuator, generator, oil and charge air: what outlives the supply (A-47)."""

from dataclasses import dataclass
from math import copysign, exp, pi
from operator import attrgetter

RADIANS = pi / 30  # rad/s per rpm
SUBSTEP = 0.003125  # s, a fifth of the governor's main cycle

INERTIA = 10.0  # kg m2
FULL_TORQUE = 1900.0  # N m
COMBUSTION_SPEED = 60.0  # rpm, below which no charge ignites
STARTER_TORQUE = 600.0  # N m, at standstill
STARTER_SPEED = 270.0  # rpm, at which it pulls no more
GENERATOR_EFFICIENCY = 0.95
ACTUATOR_LAG, ACTUATOR_RATE = 0.04, 4.0  # s, 1/s
COMBUSTION_LAG = 0.06  # s
OIL_LAG, AIR_LAG = 1.0, 8.0  # s
OIL_SPEED = 50.0  # rpm, below which the pump builds up nothing
AMBIENT = 25.0  # degC
RATED_POWER = 200_000.0  # W
STANDSTILL = 10.0  # rpm


@dataclass
class Engine:
    """A genset: `run_to` brings it to the present with the inputs as they were meanwhile."""

    load: float = 0.0
    """What the consumers want, W."""
    connected: bool = False
    """Whether the generator breaker is closed."""
    starter: bool = False
    fuel: float = 0.0
    """Actuator command, 0..1."""
    speed: float = 0.0
    """rpm"""
    position: float = 0.0
    """Of the actuator, 0..1."""
    combustion: float = 0.0
    """What burns of the full quantity, 0..1."""
    oil_pressure: float = 0.0
    """bar"""
    charge_air: float = AMBIENT
    """degC"""
    fuel_cut: bool = False
    """Whether no fuel comes, whatever the actuator does."""
    oil_lost: float = 0.0
    """How much of its pressure the oil has lost, 0..1."""
    cooling_lost: float = 0.0
    """How much warmer the charge air gets, K."""
    reached: int = 0
    """How far it has been brought, in microseconds of the supply period."""

    @property
    def power(self) -> float:
        """What the generator delivers, W."""
        return self.load if self.connected else 0.0

    @property
    def turning(self) -> bool:
        """Whether it has not come to rest."""
        return self.speed >= STANDSTILL

    def run_to(self, now: int) -> None:
        """Let the time up to `now`, in microseconds, pass."""
        seconds = (now - self.reached) / 1_000_000
        self.reached = now
        self.run(seconds)

    def run(self, seconds: float) -> None:
        """Let time pass with the inputs as they are."""
        substeps = max(1, round(seconds / SUBSTEP))
        for _ in range(substeps):
            self._move(seconds / substeps)
            if self.speed == self.fuel == 0 and not self.starter and self.position < 1e-9:
                break  # the rest of the time changes nothing
        self._settle(seconds)

    def let_go(self) -> None:
        """Nobody holds actuator, starter and generator breaker any more."""
        self.fuel, self.starter, self.connected = 0.0, False, False

    def _move(self, dt: float) -> None:
        position, combustion, speed = self.position, self.combustion, self.speed
        rate = (self.fuel - position) / ACTUATOR_LAG
        if abs(rate) > ACTUATOR_RATE:
            rate = copysign(ACTUATOR_RATE, rate)
        position += rate * dt
        burning = 0.0 if self.fuel_cut else position
        combustion += (burning - combustion) / COMBUSTION_LAG * dt
        speed += self._torque(speed, combustion) / INERTIA / RADIANS * dt
        self.position, self.combustion, self.speed = position, combustion, max(0.0, speed)

    def _torque(self, speed: float, combustion: float) -> float:
        driving = FULL_TORQUE * combustion if speed > COMBUSTION_SPEED else 0.0
        if self.starter:
            driving += max(0.0, STARTER_TORQUE * (1 - speed / STARTER_SPEED))
        driving -= 60 + 0.06 * speed  # friction
        if not self.connected:
            return driving
        return driving - self.load / (GENERATOR_EFFICIENCY * max(1.0, speed * RADIANS))

    def _settle(self, seconds: float) -> None:
        pressure = 2.5 + 2 * (self.speed - 700) / 800 if self.speed >= OIL_SPEED else 0.0
        if self.oil_lost:
            pressure *= 1 - self.oil_lost
        self.oil_pressure += (pressure - self.oil_pressure) * (1 - exp(-seconds / OIL_LAG))
        air = AMBIENT + 40 * self.power / RATED_POWER
        if self.cooling_lost and self.turning:
            air += self.cooling_lost
        self.charge_air += (air - self.charge_air) * (1 - exp(-seconds / AIR_LAG))


HELD = attrgetter("load", "connected", "starter", "fuel_cut", "oil_lost", "cooling_lost")
"""What acts on an engine, but for the fuel."""
MOTION = attrgetter("fuel", "position", "combustion", "speed", "oil_pressure", "charge_air")
"""What moves in one."""
