"""The four types and three variants of the POWER CHARGER. Figures are assumed except the modes."""

from dataclasses import dataclass
from enum import Enum, IntEnum

from canopen_twins.devices.charger.model.load import AirGap


class Variant(Enum):
    """What follows the type name: PC__, PC__/A, PC__/C."""

    BASE = ""
    A = "A"
    C = "C"


class Mode(IntEnum):
    """Operating modes of the charging (2002h:10h)."""

    U_CONST = 3
    I_CONST = 4
    ESA_FILM = 5
    ESA_PAPER = 6
    ESA_METALLISED = 7


class Quantity(Enum):
    """What a regulator holds."""

    VOLTAGE = "voltage"
    CURRENT = "current"
    POWER = "power"


@dataclass(frozen=True)
class Type:
    """One type. Limits of parameters are whole numbers in the unit of the parameter: V and uA."""

    name: str
    mode: Mode  # factory setting and range: 2002h:10h
    lowest_mode: Mode
    highest_mode: Mode
    minimum_voltage: int  # V
    maximum_voltage: int
    minimum_current: int  # uA
    maximum_current: int
    power: float  # W, of the charging output
    supply_power: float  # W, that may be drawn from the supply
    bar: AirGap
    capacitance: float  # F, of cable and bar
    minimum_voltage_discharging: int = 1000  # V
    maximum_voltage_discharging: int = 5000
    current_discharging: int = 3000  # uA, the setpoint 2002h:1Fh
    power_discharging: float = 5.0  # W


@dataclass(frozen=True)
class Build:
    """A charger as it is ordered; with `superset` /A and /C have all of each other (A-20)."""

    kind: Type
    variant: Variant = Variant.BASE
    superset: bool = False

    @property
    def entries_of(self) -> Variant:
        """The variant whose entries it has."""
        return Variant.A if self.variant is Variant.C and self.superset else self.variant

    @property
    def discharges(self) -> bool:
        """Whether there is a discharging stage."""
        return self.variant is not Variant.BASE

    @property
    def finds_dirt(self) -> bool:
        """Whether it tells what is wrong with its discharging bars (6000h:07h)."""
        return self.variant is Variant.C or (self.variant is Variant.A and self.superset)


PCSC = Type(
    name="PCSC",
    mode=Mode.U_CONST,
    lowest_mode=Mode.U_CONST,
    highest_mode=Mode.I_CONST,
    minimum_voltage=1500,
    maximum_voltage=30000,
    minimum_current=250,
    maximum_current=5000,
    power=100.0,
    supply_power=140.0,
    bar=AirGap(length=2.0, onset=6e3, coefficient=3.5714e-12),
    capacitance=2e-9,
)
PCMT = Type(
    name="PCMT",
    mode=Mode.I_CONST,
    lowest_mode=Mode.U_CONST,
    highest_mode=Mode.I_CONST,
    minimum_voltage=3000,
    maximum_voltage=60000,
    minimum_current=125,
    maximum_current=2500,
    power=100.0,
    supply_power=140.0,
    bar=AirGap(length=1.0, onset=12e3, coefficient=0.75e-12),
    capacitance=3e-9,
)
PCRT = Type(
    name="PCRT",
    mode=Mode.U_CONST,
    lowest_mode=Mode.U_CONST,
    highest_mode=Mode.I_CONST,
    minimum_voltage=1000,
    maximum_voltage=20000,
    minimum_current=500,
    maximum_current=10000,
    power=120.0,
    supply_power=165.0,
    bar=AirGap(length=3.0, onset=5e3, coefficient=8e-12),
    capacitance=3e-9,
)
PCTL = Type(
    name="PCTL",
    mode=Mode.ESA_FILM,
    lowest_mode=Mode.ESA_FILM,
    highest_mode=Mode.ESA_METALLISED,
    minimum_voltage=1000,
    maximum_voltage=20000,
    minimum_current=250,
    maximum_current=5000,
    power=75.0,
    supply_power=110.0,
    bar=AirGap(length=1.5, onset=4e3, coefficient=6e-12),
    capacitance=1.5e-9,
)
TYPES = {kind.name: kind for kind in (PCSC, PCMT, PCRT, PCTL)}
