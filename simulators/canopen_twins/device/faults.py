"""What can go wrong: one vocabulary for scenarios, tests and the command line."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import Any, NamedTuple

from canopen_twins.errors import UserError, unknown
from canopen_twins.files.convert import convert

OTHER_WORDS: Mapping[str, Sequence[str]] = {
    "absent": ("boot_up_lost", "bus_off"),
    "abort": ("sdo_abort",),
    "bit_error": ("frame_corrupt",),
    "blackout": ("power_cycle",),
    "boot_up_missing": ("boot_up_lost",),
    "brownout": ("brown_out",),
    "bus_error": ("error_passive", "bus_off"),
    "cable_break": ("bus_off",),
    "crc_error": ("frame_corrupt",),
    "crash": ("reset_loop",),
    "disconnected": ("bus_off",),
    "emcy_missing": ("emcy_lost",),
    "emergency": ("error",),
    "emergency_stop": ("interlock_open", "emergency_stop_lost"),
    "frame_delayed": ("frame_late",),
    "frame_duplicated": ("frame_doubled",),
    "frame_missing": ("frame_lost",),
    "heartbeat_lost": ("heartbeat_stopped",),
    "heartbeat_missing": ("heartbeat_stopped",),
    "heartbeat_timeout": ("heartbeat_stopped",),
    "interlock": ("interlock_open",),
    "mains_failure": ("mains", "power_cycle"),
    "node_lost": ("bus_off",),
    "ocp": ("error",),
    "otp": ("overtemperature", "error"),
    "overcurrent": ("error",),
    "overheating": ("overtemperature", "error"),
    "overload": ("error",),
    "overvoltage": ("error",),
    "ovp": ("error",),
    "packet_loss": ("frame_lost",),
    "pdo_lost": ("pdo_missing",),
    "pdo_timeout": ("pdo_missing",),
    "power_fail": ("power_cycle",),
    "power_loss": ("power_cycle",),
    "reboot": ("reset_loop", "power_cycle"),
    "sdo_lost": ("sdo_silence",),
    "sdo_missing": ("sdo_silence",),
    "sdo_slow": ("sdo_late",),
    "sdo_timeout": ("sdo_silence",),
    "short_circuit": ("short",),
    "shorted": ("short",),
    "timeout": ("sdo_silence",),
    "toggle_error": ("sdo_wrong_toggle",),
    "undervoltage": ("supply", "mains", "brown_out"),
    "watchdog": ("reset_loop",),
}
"""What the field says for faults that are called otherwise here, best first."""
KINDS: Mapping[type, str] = {
    int: "integer",
    float: "number",
    str: "text",
    object: "number or text",
}
"""What a parameter is, in words."""
LARGEST: Mapping[type, float] = {int: 2**63 - 1, float: 1e9, object: 2**63 - 1}
"""What no number is beyond, on either side of 0: in seconds it is longer than any run."""
WEATHERS = ("mild", "rough", "hostile")


class Weather(NamedTuple):
    """From which weather on a fault is to be expected, and why; a hunt asks for it."""

    least: str = "rough"
    """One of `WEATHERS`."""
    why: str = "devices fail now and then"


USUAL = Weather()


class Parameter(NamedTuple):
    """One parameter of a fault: what it means, and its value when nobody says otherwise.

    A parameter without default has to be given. A number has to be in `low`..`high`, and is never
    beyond `LARGEST`; one of kind `object` is a number or a text. `examples` are what a hunt tries
    where the range does not tell. One that `delays_answers` says by how many seconds an answer to
    the master is late: a hunt tries for how long he waits for it.
    """

    text: str
    default: int | float | str | None = None
    kind: type[int] | type[float] | type[str] | type[object] = float
    low: float = -inf
    high: float = inf
    examples: tuple[int | float | str, ...] = ()
    delays_answers: bool = False

    @property
    def declaration(self) -> Mapping[str, object]:
        """What programs are told of it; None for an end that a number has not."""
        return {
            "text": self.text,
            "type": KINDS[self.kind],
            "default": self.default,
            "low": self.low if isfinite(self.low) else None,
            "high": self.high if isfinite(self.high) else None,
        }


@dataclass(frozen=True)
class Fault:
    """Something that can be injected and cleared by name.

    `inject` is called with every parameter as a keyword, `clear` later with the same. A fault
    without `clear` is over at once: what it leaves behind is the device's to reset. One that heals
    by itself says through `over` when it has.
    """

    text: str
    inject: Callable[..., None]
    clear: Callable[..., None] | None = None
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    level: str = "device"
    sees: str = ""
    """What a master should see of it, if the text does not say so."""
    over: Callable[[], bool] = lambda: False
    weather: Weather = USUAL

    @property
    def declaration(self) -> Mapping[str, object]:
        """What programs are told of it, for a form.

        A parameter without a default has to be given.
        """
        parameters = {name: told.declaration for name, told in self.parameters.items()}
        return {
            "level": self.level,
            "text": self.text,
            "sees": self.sees,
            "lasting": self.clear is not None,
            "weather": self.weather.least,
            "why": self.weather.why,
            "parameters": parameters,
        }


class Faults:
    """The faults of one device and those around it, and which of them are active.

    Raises:
        ValueError: a device has a fault of a name that has a meaning for every device.
    """

    def __init__(
        self, of_device: Mapping[str, Fault], around: Mapping[str, Fault] | None = None
    ) -> None:
        self._around = around or {}
        self._take(of_device)
        self._injected: dict[str, dict[str, Any]] = {}

    @property
    def active(self) -> Mapping[str, Mapping[str, Any]]:
        """The faults that are there at this moment, with their parameters."""
        injected = self._injected.items()
        return {name: values for name, values in injected if not self.known[name].over()}

    def inject(self, name: str, /, **given: Any) -> None:
        """Let something go wrong; a fault that is active already is replaced.

        Raises:
            UserError: no such fault, an unknown or missing parameter, or a wrong value.
        """
        fault = self.find(name)
        values = arguments(name, fault, given)
        self.clear(name)
        fault.inject(**values)
        if fault.clear is not None:
            self._injected[name] = values

    def clear(self, name: str | None = None) -> None:
        """Take one fault away, or all of them; the device recovers as far as it does by itself.

        Raises:
            UserError: no such fault.
        """
        for each in [name] if name is not None else list(self._injected):
            fault = self.find(each)
            values = self._injected.pop(each, None)
            if values is not None and fault.clear is not None:
                fault.clear(**values)

    def renew(self, of_device: Mapping[str, Fault]) -> None:
        """Inject again what a power cycle took from the device: a cause outlives it.

        Its faults are told anew, as those before it may act on the model before it.
        """
        self._take(of_device)
        for name, values in self._injected.items():
            if name in self._of_device:
                self.known[name].inject(**values)

    def _take(self, of_device: Mapping[str, Fault]) -> None:
        if twice := of_device.keys() & self._around.keys():
            raise ValueError(f"every device has a fault {min(twice)!r}: name yours otherwise")
        self.known = {**of_device, **self._around}
        self._of_device = of_device

    def words(self, name: str, values: Mapping[str, Any]) -> str:
        """A fault with those of its parameters that somebody has chosen."""
        told = self.known[name].parameters
        chosen = [f"{key}={value}" for key, value in values.items() if value != told[key].default]
        return f"{name}({', '.join(chosen)})"

    def find(self, name: str) -> Fault:
        """What is called so; raises `UserError` if nothing is."""
        if name not in self.known:
            raise unknown("fault", name, self.known, OTHER_WORDS)
        return self.known[name]


def arguments(name: str, fault: Fault, given: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters a fault is injected with: those given over the defaults.

    Raises:
        UserError: an unknown parameter, one that is missing, or a value of the wrong kind.
    """
    values = {key: told.default for key, told in fault.parameters.items()}
    values |= {key: argument(name, fault, key, value) for key, value in given.items()}
    for parameter, value in values.items():
        if value is None:
            raise UserError(
                f"fault {name!r} wants {parameter!r}: {fault.parameters[parameter].text}"
            )
    return values


def argument(name: str, fault: Fault, parameter: str, value: object) -> Any:
    """One parameter as the fault takes it.

    Raises:
        UserError: the fault has no such parameter, or the value is of the wrong kind or size.
    """
    if parameter not in fault.parameters:
        raise unknown(f"parameter of fault {name!r}", parameter, fault.parameters)
    told = fault.parameters[parameter]
    taken = convert(f"parameter {parameter!r} of fault {name!r}", value, told.kind)
    if not isinstance(taken, (int, float)):
        return taken
    largest = LARGEST[told.kind]
    low, high = max(told.low, -largest), min(told.high, largest)
    if not low <= taken <= high:
        size, end = ("less", low) if taken < low else ("more", high)
        raise UserError(f"parameter {parameter!r} of fault {name!r}: {value} is {size} than {end}")
    return taken
