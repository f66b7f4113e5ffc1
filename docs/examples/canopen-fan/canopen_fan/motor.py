"""A fan and its motor: pure physics in rpm and seconds, which know no CAN."""

from dataclasses import dataclass


@dataclass
class Motor:
    """Follows its target speed with a time constant."""

    time_constant: float = 0.5  # s
    target: float = 0.0  # rpm
    speed: float = 0.0  # rpm
    blocked: bool = False

    @property
    def settled(self) -> bool:
        """Whether nothing changes as long as nobody acts."""
        return self.speed == self._aim

    def turn(self, rpm: float) -> None:
        """Aim at another speed."""
        self.target = rpm

    def block(self) -> None:
        """Something keeps the wheel from turning."""
        self.blocked = True

    def free(self) -> None:
        """The wheel can turn again."""
        self.blocked = False

    def step(self, dt: float) -> None:
        """Let `dt` seconds pass."""
        self.speed += (self._aim - self.speed) * min(1.0, dt / self.time_constant)
        if abs(self.speed - self._aim) < 0.5:
            self.speed = self._aim

    @property
    def _aim(self) -> float:
        return 0.0 if self.blocked else self.target
