"""What can go wrong with a charger: around it, in it, and every message of the catalogue."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING

from simulators.devices.charger import disturbances, messages
from simulators.devices.charger.disturbances import SENSORS
from simulators.devices.charger.model.catalogue import Kind
from simulators.devices.charger.model.charger import Key
from simulators.devices.charger.model.release import Source
from simulators.devices.charger.model.sparks import WINDOW
from simulators.devices.charger.model.surroundings import Surroundings
from simulators.errors import UserError, unknown
from simulators.faults import Fault, Parameter

if TYPE_CHECKING:
    from simulators.devices.charger import Device

MILLI = 1e-3
KEYPAD, TOUCH = "keypad", "touch"
PLACES = (KEYPAD, TOUCH)

AROUND: Mapping[Callable[..., Surroundings], tuple[str, Mapping[str, Parameter]]] = {
    disturbances.spark_storm: (
        "Random sparks of all sizes while high voltage is on.",
        {
            "rate": Parameter("sparks in a second, at the breakdown voltage"),
            "seed": Parameter("of the random numbers", 0, int),
            "breakdown": Parameter("V", 0.0),
            "scale": Parameter("V for e times as many; 0: whatever the voltage", 0.0),
        },
    ),
    disturbances.short: ("The charging electrode is short-circuited.", {}),
    disturbances.open_electrode: ("Nothing is connected to the charging terminal.", {}),
    disturbances.conductive_pollution: (
        "Conductive dirt on the charging bar: current leaks past the tips.",
        {"megaohm": Parameter("of the leak", 10.0)},
    ),
    disturbances.insulating_pollution: (
        "Insulating dirt on the charging bar: tips are covered.",
        {"percent": Parameter("of the bar that is covered, 0..100", 50.0)},
    ),
    disturbances.discharging_pollution: (
        "Dirt on a discharging bar: it takes another power.",
        {
            "connector": Parameter("1 or 2", 1, int),
            "percent": Parameter("of the power of a clean bar; more than 150 is conductive", 200.0),
        },
    ),
    disturbances.hardware_release_lost: (
        "The contact of the hardware release opens: no high voltage, and no message.",
        {},
    ),
    disturbances.discharging_release_lost: (
        "The contact of the hardware release for the discharging opens.",
        {},
    ),
    disturbances.analog: (
        "The analog input is driven; 0x2002:02 and 03 say what it does.",
        {"percent": Parameter("of 20 mA or 10 V, 0..100")},
    ),
    disturbances.supply: (
        "The supply leaves its 24 V.",
        {"volts": Parameter("without load, 6..40 V")},
    ),
    disturbances.overtemperature: (
        "A temperature is higher than the losses explain.",
        {
            "sensor": Parameter(", ".join(SENSORS), SENSORS[0], str),
            "kelvin": Parameter("by so many K", 70.0),
        },
    ),
}
SPARK = {
    "slope": Parameter("mA/ms"),
    "rise_time": Parameter("ms; the detector looks at 8 ms at least", 8.0),
}
MESSAGE = {
    "key": Parameter("its key in the catalogue", "", str),
    "number": Parameter("or its number", 0, int),
    "code": Parameter("with a number: the EMCY code of a message that is not there", 0, int),
}
PLACE = {"at": Parameter("keypad, which 0x2002:1C locks, or touch", KEYPAD, str)}


def faults(device: Device) -> Mapping[str, Fault]:
    """Every fault by its name; the device is asked for its charger when one is used."""
    return {
        "spark": Fault(
            "A spark, if high voltage is on; its steepness says what it counts as.",
            partial(_spark, device),
            parameters=SPARK,
        ),
        **{change.__name__: _around(device, change) for change in AROUND},
        "hmi_on": Fault(
            "Somebody gives the release at the charger itself.",
            partial(_operate, device, Key.ON),
            parameters=PLACE,
        ),
        "hmi_off": Fault(
            "Somebody takes the release away at the charger itself.",
            partial(_operate, device, Key.OFF),
            parameters=PLACE,
        ),
        "memory_failure": Fault(
            "The memory takes nothing any more: no 0x1010, no LSS store, no hours.",
            partial(_wear, device, True),
            partial(_wear, device, False),
        ),
        **{kind.name.lower(): _message(device, kind) for kind in Kind},
    }


def _around(device: Device, change: Callable[..., Surroundings]) -> Fault:
    """Something in the surroundings is otherwise until it is cleared."""
    text, parameters = AROUND[change]

    def inject(**values: object) -> None:
        change(device.charger.surroundings, **values)  # refuses before anything has changed
        device.plant.disturb(change.__name__, partial(change, **values))
        device.apply()

    def clear(**values: object) -> None:
        device.plant.calm(change.__name__)
        device.apply()

    return Fault(text, inject, clear, parameters)


def _message(device: Device, kind: Kind) -> Fault:
    name = kind.name.lower()
    return Fault(
        f"Any {name}; its cause lasts until this fault is cleared, the {name} until 0x2003 is.",
        lambda **told: device.charger.force(messages.find(device.catalogue, kind, **told)),
        lambda **told: device.charger.unforce(messages.find(device.catalogue, kind, **told)),
        MESSAGE,
    )


def _spark(device: Device, slope: float, rise_time: float) -> None:
    if rise_time < 0 or slope < 0:
        raise UserError("a spark has a slope and a rise time of 0 or more")
    duration = rise_time * MILLI
    device.charger.spark(slope * max(WINDOW, duration), duration)  # mA/ms is A/s


def _operate(device: Device, key: Key, at: str) -> None:
    charger = device.charger
    if at not in PLACES:
        raise unknown("place", at, PLACES)
    if at == KEYPAD:
        charger.press(key)
    else:
        {Key.ON: charger.grant, Key.OFF: charger.revoke}[key](Source.HMI)


def _wear(device: Device, worn: bool) -> None:
    device.memory.worn = worn
    if message := device.catalogue.keyed(Kind.ERROR, "parameter_memory"):
        (device.charger.force if worn else device.charger.unforce)(message)
