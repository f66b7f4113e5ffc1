"""The fan at a glance: which object acts on what, what it tells, and what can go wrong."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path

from canopen_fan.motor import Motor
from canopen_twins.device.chart import Band, Chart, Curve, Mood
from canopen_twins.device.device import Device, NodeSettings
from canopen_twins.device.faults import Fault
from canopen_twins.device.settings import setting
from canopen_twins.slave.emcy import Emcy
from canopen_twins.slave.object import Address, Object

BLOCKED = Emcy(0x7121, 0x81, label="motor blocked")
FREE, STUCK = Band("free", Mood.ACTIVE), Band("stuck", Mood.ERROR)


@dataclass(frozen=True)
class Settings(NodeSettings):
    """What can be chosen of a fan."""

    time_constant: float = setting(0.5, "of the motor with its wheel", unit="s", low=0.01)


class Fan(Device):
    """A fan behind a CANopen speed controller."""

    eds = str(Path(__file__).with_name("fan.eds"))
    title = "Example fan with CANopen speed controller"
    settings_type = Settings
    cycle = 0.01

    def __init__(self, **given: object) -> None:
        super().__init__(**given)
        self.power_on()  # a model is there without power, too: a scenario is tried on it

    def power_on(self) -> None:
        """It stands still."""
        self.motor = Motor(self.settings.time_constant)

    @property
    def objects(self) -> Mapping[Address, Object]:
        """One line for each entry that acts; what is not named is plain memory of the node."""
        motor = self.motor
        return {
            (0x2000, 0): Object(write=lambda rpm: setattr(motor, "target", rpm)),
            (0x2001, 0): Object(read=lambda: round(motor.speed)),
        }

    @property
    def emergencies(self) -> Sequence[Emcy]:
        """What is wrong at this moment."""
        return (BLOCKED,) if self.motor.blocked else ()

    @property
    def faults(self) -> Mapping[str, Fault]:
        """Beside those every device has."""
        return {
            "blocked": Fault(
                "Something keeps the wheel from turning (EMCY 7121h).",
                lambda: setattr(self.motor, "blocked", True),
                lambda: setattr(self.motor, "blocked", False),
            )
        }

    @property
    def report(self) -> Mapping[str, object]:
        """What a failed test shows."""
        return {"speed [rpm]": round(self.motor.speed), "blocked": self.motor.blocked}

    @property
    def chart(self) -> Chart:
        """What a picture of a run draws."""
        speed = Curve("Speed", "rpm", lambda: self.motor.speed, lambda: self.motor.target)
        return Chart([speed], lambda: STUCK if self.motor.blocked else FREE)

    @property
    def rest(self) -> float:
        """A fan at its speed need not be stepped: an hour of it costs nothing."""
        return inf if self.motor.settled else 0.0

    def step(self, dt: float) -> None:
        """Let time pass in the model."""
        self.motor.step(dt)
