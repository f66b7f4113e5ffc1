"""The fan at a glance: which object acts on what, what it tells, and what can go wrong."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path

from canopen_fan.motor import Motor
from canopen_twins import device

BLOCKED = device.Emcy(0x7121, 0x81, label="motor blocked")
FREE, STUCK = device.Band("free", device.Mood.ACTIVE), device.Band("stuck", device.Mood.ERROR)


@dataclass(frozen=True)
class Settings(device.NodeSettings):
    time_constant: float = device.setting(0.5, "of the motor with its wheel", unit="s", low=0.01)


class Fan(device.Device):
    """A fan behind a CANopen speed controller."""

    eds = str(Path(__file__).with_name("fan.eds"))
    title = "Example fan with CANopen speed controller"
    settings = Settings()

    def make_model(self) -> None:
        self.motor = Motor(self.settings.time_constant)

    @property
    def objects(self) -> Mapping[device.Address, device.Object]:
        speed = device.Object(read=lambda: round(self.motor.speed))
        return {(0x2000, 0): device.Object(write=self.motor.turn), (0x2001, 0): speed}

    @property
    def emergencies(self) -> Sequence[device.Emcy]:
        return (BLOCKED,) if self.motor.blocked else ()

    @property
    def faults(self) -> Mapping[str, device.Fault]:
        text = "Something keeps the wheel from turning (EMCY 7121h)."
        return {"blocked": device.Fault(text, self.motor.block, self.motor.free)}

    @property
    def report(self) -> Mapping[str, object]:
        return {"speed [rpm]": round(self.motor.speed), "blocked": self.motor.blocked}

    @property
    def chart(self) -> device.Chart:
        motor = self.motor
        speed = device.Curve("Speed", "rpm", lambda: motor.speed, lambda: motor.target)
        return device.Chart([speed], lambda: STUCK if motor.blocked else FREE)

    @property
    def rest(self) -> float:
        return inf if self.motor.settled else 0.0  # at its speed an hour of it costs nothing

    def step(self, dt: float) -> None:
        self.motor.step(dt)
