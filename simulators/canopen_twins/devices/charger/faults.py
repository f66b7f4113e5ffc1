"""What goes wrong with a charger and around it; what cannot be is refused with `UserError`."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import NamedTuple

from canopen_twins.device import Fault, Memory, Parameter, Weather
from canopen_twins.devices.charger import messages
from canopen_twins.devices.charger.model.charger import Charger, Key
from canopen_twins.devices.charger.model.load import OPEN, SHORT
from canopen_twins.devices.charger.model.messages import Catalogue, Severity
from canopen_twins.devices.charger.model.release import ReleaseSource
from canopen_twins.devices.charger.model.sparks import WINDOW, Storm
from canopen_twins.devices.charger.model.surroundings import Surroundings
from canopen_twins.errors import UserError, unknown

MEGA, MILLI, PERCENT = 1e6, 1e-3, 1e-2
LOWEST_SUPPLY, HIGHEST_SUPPLY = 6.0, 40.0  # V
SENSORS = ("power_stage", "inside", "cascade", "discharging")
CONNECTORS = (1, 2)
KEYPAD, TOUCH = "keypad", "touch"
PLACES = (KEYPAD, TOUCH)
SPARK = {
    "slope": Parameter("mA/ms", examples=(1.0, 10.0, 100.0)),
    "rise_time": Parameter("ms; the detector looks at 8 ms at least", 8.0),
}
MESSAGE = {
    "key": Parameter("its key in the catalogue", "", str),
    "number": Parameter("or its number", 0, int, examples=(0x0B, 0x01, 0x02)),
    "code": Parameter("with a number: the EMCY code of a message that is not there", 0, int),
}
PLACE = {"at": Parameter("keypad, which 0x2002:1C locks, or touch", KEYPAD, str)}


def _spark_storm(
    around: Surroundings, rate: float, seed: int, breakdown: float, scale: float
) -> Surroundings:
    """Sparks at random; `scale` 0 V: the voltage does not matter."""
    if rate < 0 or scale < 0:
        raise UserError("a storm has a rate and a scale of 0 or more")
    storm = Storm(rate, seed, breakdown, scale) if scale else Storm(rate, seed)
    return replace(around, storm=storm)


def _discharging_pollution(around: Surroundings, connector: int, percent: float) -> Surroundings:
    if connector not in CONNECTORS:
        raise UserError(f"discharging bars are connected to 1 and 2, not to {connector}")
    power, (first, second) = _positive("percent", percent) * PERCENT, around.bars.power
    powers = (power, second) if connector == 1 else (first, power)
    return replace(around, bars=around.bars._replace(power=powers))


def _supply(around: Surroundings, volts: float) -> Surroundings:
    if not LOWEST_SUPPLY <= volts <= HIGHEST_SUPPLY:
        raise UserError(f"a supply of {volts} V: 6..40 V; without any the power is off")
    return replace(around, supply_voltage=volts)


def _overtemperature(around: Surroundings, sensor: str, kelvin: float) -> Surroundings:
    if sensor not in SENSORS:
        raise unknown("sensor", sensor, SENSORS)
    return replace(around, heat={**around.heat, sensor: kelvin})


def _share(percent: float) -> float:
    if not 0 <= percent <= 100:
        raise UserError(f"{percent} % is not in 0..100")
    return percent * PERCENT


def _positive(what: str, value: float) -> float:
    if value <= 0:
        raise UserError(f"{what} is above 0, not {value}")
    return value


class Around(NamedTuple):
    """Something that makes other surroundings of those that are there."""

    text: str
    change: Callable[..., Surroundings]
    parameters: Mapping[str, Parameter]


AROUND: Mapping[str, Around] = {
    "spark_storm": Around(
        "Random sparks of all sizes while high voltage is on.",
        _spark_storm,
        {
            "rate": Parameter("sparks in a second, at the breakdown voltage", examples=(1.0, 20.0)),
            "seed": Parameter("of the random numbers", 0, int),
            "breakdown": Parameter("V", 0.0),
            "scale": Parameter("V for e times as many; 0: whatever the voltage", 0.0),
        },
    ),
    "short": Around(
        "The charging electrode is short-circuited.",
        lambda around: replace(around, electrode=SHORT),
        {},
    ),
    "open_electrode": Around(
        "Nothing is connected to the charging terminal.",
        lambda around: replace(around, electrode=OPEN),
        {},
    ),
    "conductive_pollution": Around(
        "Conductive dirt on the charging bar: current leaks past the tips.",
        lambda around, megaohm: replace(around, leak=_positive("megaohm", megaohm) * MEGA),
        {"megaohm": Parameter("of the leak", 10.0)},
    ),
    "insulating_pollution": Around(
        "Insulating dirt on the charging bar: tips are covered.",
        lambda around, percent: replace(around, active=1 - _share(percent)),
        {"percent": Parameter("of the bar that is covered, 0..100", 50.0)},
    ),
    "discharging_pollution": Around(
        "Dirt on a discharging bar: it takes another power.",
        _discharging_pollution,
        {
            "connector": Parameter("1 or 2", 1, int),
            "percent": Parameter("of the power of a clean bar; more than 150 is conductive", 200.0),
        },
    ),
    "hardware_release_lost": Around(
        "The contact of the hardware release opens: no high voltage, and no message.",
        lambda around: replace(around, hardware_release=False),
        {},
    ),
    "discharging_release_lost": Around(
        "The contact of the hardware release for the discharging opens.",
        lambda around: replace(around, hardware_release_discharging=False),
        {},
    ),
    "analog": Around(
        "The analog input is driven; 0x2002:02 and 03 say what it does.",
        lambda around, percent: replace(around, analog=_share(percent) / PERCENT),
        {"percent": Parameter("of 20 mA or 10 V, 0..100", low=0, high=100)},
    ),
    "supply": Around(
        "The supply leaves its 24 V.",
        _supply,
        {"volts": Parameter("without load, 6..40 V", examples=(18.0, 10.0, 32.0))},
    ),
    "overtemperature": Around(
        "A temperature is higher than the losses explain.",
        _overtemperature,
        {
            "sensor": Parameter(", ".join(SENSORS), SENSORS[0], str, examples=SENSORS),
            "kelvin": Parameter("by so many K", 70.0),
        },
    ),
}


Change = Callable[[Surroundings], Surroundings]


class Faults:
    """Every fault of one charger, and what it acts upon.

    Args:
        charger: The model.
        catalogue: Its messages.
        memory: What it keeps its parameters in.
        disturb: Has surroundings changed by a fault of that name, or no longer changed.
        late: Milliseconds since the last tick of the charger.
    """

    def __init__(
        self,
        charger: Charger,
        catalogue: Catalogue,
        memory: Memory,
        disturb: Callable[[str, Change | None], None],
        late: Callable[[], int],
    ) -> None:
        self._charger = charger
        self._catalogue = catalogue
        self._memory = memory
        self._disturb = disturb
        self._late = late

    @property
    def by_name(self) -> Mapping[str, Fault]:
        """The faults."""
        return {
            "spark": Fault(
                "A spark, if high voltage is on; its steepness says what it counts as.",
                self._spark,
                parameters=SPARK,
            ),
            **{name: self._around(name, around) for name, around in AROUND.items()},
            "hmi_on": Fault(
                "Somebody gives the release at the charger itself.",
                partial(self._operate, Key.ON),
                parameters=PLACE,
            ),
            "hmi_off": Fault(
                "Somebody takes the release away at the charger itself.",
                partial(self._operate, Key.OFF),
                parameters=PLACE,
            ),
            "memory_failure": Fault(
                "The memory takes nothing any more: no 0x1010, no LSS store, no hours.",
                partial(self._wear, worn=True),
                partial(self._wear, worn=False),
                weather=Weather("hostile", "a broken memory has to be repaired"),
            ),
            **{each.name.lower(): self._message(each) for each in Severity},
        }

    def _around(self, name: str, around: Around) -> Fault:
        """Something in the surroundings is otherwise until it is cleared."""

        def inject(**values: object) -> None:
            change = partial(around.change, **values)
            change(self._charger.surroundings)  # refuses before anything has changed
            self._disturb(name, change)

        def clear(**values: object) -> None:
            self._disturb(name, None)

        return Fault(around.text, inject, clear, around.parameters)

    def _message(self, severity: Severity) -> Fault:
        name = severity.name.lower()
        charger, find = self._charger, partial(messages.find, self._catalogue, severity)
        return Fault(
            f"Any {name}; its cause lasts until this fault is cleared, the {name} until 0x2003 is.",
            lambda **told: charger.force(find(**told)),
            lambda **told: charger.unforce(find(**told)),
            MESSAGE,
        )

    def _spark(self, slope: float, rise_time: float) -> None:
        if rise_time < 0 or slope < 0:
            raise UserError("a spark has a slope and a rise time of 0 or more")
        duration = rise_time * MILLI
        current = slope * max(WINDOW, duration)  # mA/ms is A/s
        self._charger.spark(current, duration, self._late())

    def _operate(self, key: Key, at: str) -> None:
        charger = self._charger
        if at not in PLACES:
            raise unknown("place", at, PLACES)
        if at == KEYPAD:
            charger.press(key)
        else:
            {Key.ON: charger.grant, Key.OFF: charger.revoke}[key](ReleaseSource.HMI)

    def _wear(self, worn: bool) -> None:
        charger = self._charger
        self._memory.worn = worn
        if message := self._catalogue.keyed(Severity.ERROR, "parameter_memory"):
            (charger.force if worn else charger.unforce)(message)
