"""Settings of the charger twin, and what they order and connect.

An A-number marks an assumption (docs/devices/charger.md).
"""

from dataclasses import dataclass
from typing import Literal

from canopen_twins.device import NodeSettings, setting
from canopen_twins.devices.charger.model.discharging import Bars
from canopen_twins.devices.charger.model.load import Electrode, Resistor, Web
from canopen_twins.devices.charger.model.release import BUS, EVERY, ReleaseSource
from canopen_twins.devices.charger.model.sparks import Counting, Sparks, SparkValue
from canopen_twins.devices.charger.model.surroundings import Surroundings
from canopen_twins.devices.charger.model.ticks import MINUTE, Hours
from canopen_twins.devices.charger.model.types import TYPES, Build, Variant
from canopen_twins.errors import UserError
from canopen_twins.files.convert import convert

UNSIGNED32 = 0xFFFF_FFFF
MICRO = 1e-6
HOUR = 60 * MINUTE


@dataclass(frozen=True)
class Settings(NodeSettings):
    """What can be chosen of a POWER CHARGER and of what surrounds it."""

    node_id: int = setting(99, "0x2002:06 as delivered; a stored one wins", low=1, high=127)

    # the charger
    kind: Literal["PCSC", "PCMT", "PCRT", "PCTL"] = setting(
        "PCSC", "type, as 0x1008 tells it", assumed="A-71"
    )
    variant: Literal["base", "A", "C"] = setting("base", "what follows the type: nothing, /A or /C")
    variant_policy: Literal["letter", "superset"] = setting(
        "letter",
        "what /A and /C have for their discharging: what is printed, or each all of the other",
        assumed="A-20",
    )
    messages: str = setting(
        "",
        "YAML file with the numbers of chapters 6.1 and 6.2 instead of ours",
        assumed="A-37",
        file=r"^format: charger_messages/",
    )
    firmware: str = setting("0100", "0x100A, four characters", assumed="A-06")
    product_code: int = setting(1, "0x1018:2", assumed="A-33", low=0, high=UNSIGNED32)
    revision: int = setting(0x00010000, "0x1018:3", assumed="A-33", low=0, high=UNSIGNED32)
    serial: int = setting(1, "0x1018:4", assumed="A-33", low=0, high=UNSIGNED32)

    # what is around it
    load: str = setting(
        "bar", "charging electrode: bar, or resistor OHM", assumed="A-73", live=True
    )
    ambient: float = setting(
        25.0, "temperature of the air", unit="degC", assumed="A-75", live=True, low=-273
    )
    web_width: float = setting(1.5, "of the material", unit="m", assumed="A-76", live=True, low=0)
    web_speed: float = setting(0.0, "of the material", unit="m/s", assumed="A-76", live=True, low=0)
    web_charge: float = setting(
        5.0,
        "what the material brings to the discharging bar",
        unit="uC/m2",
        assumed="A-76",
        live=True,
    )
    bars: Literal["R60", "R60L", "other"] = setting(
        "R60",
        "series of the discharging bars; others cannot be watched for dirt (0x2002:28)",
        assumed="A-77",
    )

    holding_time: float = setting(
        30.0,
        "time constant with which an open terminal loses its charge",
        unit="s",
        assumed="A-80",
        live=True,
        low=0.01,
    )

    # what it has behind it
    operating_hours: float = setting(
        0.0, "0x2000:01 to 04 as delivered; stored ones win", unit="h", low=0
    )
    charging_hours: float = setting(
        0.0, "0x2000:05 to 08 as delivered; stored ones win", unit="h", low=0
    )
    discharging_hours: float = setting(
        0.0, "0x2000:09 to 0C as delivered; stored ones win", unit="h", low=0
    )

    # what the manual leaves open
    release_timeout: Literal["every", "bus"] = setting(
        "every",
        "the releases that 0x2002:04 ends: every one, or those that a bus has given",
        assumed="A-42",
    )
    heartbeat_default_ms: int = setting(
        1000, "0x1017 as delivered", unit="ms", assumed="A-01", low=0, high=60_000
    )
    heartbeat_step: Literal["reject", "floor"] = setting(
        "reject", "a heartbeat that is no multiple of 100 ms", assumed="A-02"
    )
    tpdo3_without_discharge: Literal["send", "off"] = setting(
        "send", "TPDO3 of a charger that cannot discharge", assumed="A-19"
    )
    tpdo_on_change: bool = setting(
        False, "whether a changed value is sent between two cycles", assumed="A-24"
    )
    signature: Literal["cia301", "any"] = setting(
        "cia301", 'what 0x1010 and 0x1011 want: "save" and "load", or anything', assumed="A-31"
    )
    ack_payload: Literal["identify", "zero"] = setting(
        "identify", "error field of the EMCY that confirms a clear", assumed="A-36"
    )
    spark_value: Literal["percent", "number"] = setting(
        "percent", "what Value is in the formula of the spark levels", assumed="A-56"
    )
    spark_classes: Literal["exclusive", "per_class", "cumulative"] = setting(
        "exclusive", "how many counters one spark may raise", assumed="A-57"
    )


def build(settings: Settings) -> Build:
    """Type and variant."""
    variant = Variant("" if settings.variant == "base" else settings.variant)
    return Build(TYPES[settings.kind], variant, superset=settings.variant_policy == "superset")


def detector(settings: Settings) -> Sparks:
    """The spark detector, by the reading of the manual that is wanted (A-56, A-57)."""
    return Sparks(Counting(settings.spark_classes), SparkValue[settings.spark_value.upper()])


def timed(settings: Settings) -> ReleaseSource:
    """The sources whose releases the timeout ends (A-42)."""
    return BUS if settings.release_timeout == "bus" else EVERY


def hours(settings: Settings) -> Hours:
    """What the hour counters show of a charger that has been used before."""
    given = settings.operating_hours, settings.charging_hours, settings.discharging_hours
    return Hours(*(round(each * HOUR) for each in given))


def undisturbed(settings: Settings) -> Surroundings:
    """What is around a charger when nothing is wrong.

    Raises:
        UserError: no such load.
    """
    return Surroundings(
        ambient=settings.ambient,
        electrode=electrode(settings.load),
        web=Web(settings.web_width, settings.web_speed, settings.web_charge * MICRO),
        bars=Bars(settings.bars),
        holding_time=settings.holding_time,
    )


def electrode(text: str) -> Electrode | None:
    """What is connected in the words of a setting; none is the bar of the type.

    Raises:
        UserError: neither a bar nor a resistor.
    """
    match text.split():
        case ["bar"]:
            return None
        case ["resistor", number] | ["resistor", number, "ohm"]:
            return _resistor(number)
    raise UserError(f"setting 'load' is 'bar' or 'resistor OHM', not {text!r}")


def _resistor(number: str) -> Resistor:
    resistance = convert("setting 'load': the resistor", number, float)
    assert isinstance(resistance, float)
    if resistance <= 0:
        raise UserError(f"setting 'load': a resistor of {number} ohm is none")
    return Resistor(resistance)
