"""Settings of a device: a frozen dataclass whose fields say what they mean and who assumed them."""

from collections.abc import Mapping
from dataclasses import Field, dataclass, field, fields, replace
from functools import cache
from math import inf, isfinite
from types import UnionType
from typing import Any, Literal, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

from canopen_twins.errors import UserError, unknown
from canopen_twins.files.convert import convert

Settings = TypeVar("Settings")

KINDS: Mapping[type, str] = {bool: "boolean", int: "integer", float: "number", str: "text"}


def setting(  # noqa: PLR0913 - each is a word about one setting
    default: Any,
    text: str,
    *,
    unit: str = "",
    assumed: str = "",
    live: bool = False,
    low: float = -inf,
    high: float = inf,
    file: str = "",
) -> Any:
    """A field of a settings dataclass.

    Args:
        default: Its value when nobody says otherwise.
        text: What it means, for `--help` and the docs.
        unit: Of a number.
        assumed: The number of the assumption behind the default, if no manual prints it.
        live: Whether it may change while the device runs (`set` in a scenario).
        low: The least number it takes.
        high: The greatest.
        file: For the path of a file: a regular expression, multi-line, for what no other kind of
            file says, so that `canopen-twin check FILE` knows whose it is.
    """
    told = About(text, unit, assumed, live, low, high, file)
    return field(default=default, metadata={"about": told})


class About(NamedTuple):
    """What is told of a setting beside its type and default."""

    text: str
    unit: str = ""
    assumed: str = ""
    live: bool = False
    low: float = -inf
    high: float = inf
    file: str = ""

    @property
    def range(self) -> str:
        """The numbers it takes, in words; empty for any."""
        if self.high < inf:
            return f"{self.low} to {self.high}"
        return f"{self.low} or more" if self.low > -inf else ""


def about(entry: "Field[Any]") -> About:
    """What is told of a field."""
    told: About = entry.metadata["about"]
    return told


def declaration(entry: "Field[Any]", settings: type) -> Mapping[str, object]:
    """What programs are told of a field of a dataclass of settings, for a form.

    The type is one of boolean, integer, number, text and choice; None is for an end that there is
    not, and for `none` where it is optional.
    """
    told, hint = about(entry), _types(settings)[entry.name]
    options = get_args(hint)
    choices = list(options) if get_origin(hint) is Literal else []
    optional = isinstance(hint, UnionType)
    kind = next(each for each in options if each is not type(None)) if optional else hint
    return {
        "text": told.text,
        "type": "choice" if choices else KINDS[kind],
        "choices": choices,
        "optional": optional,
        "unit": told.unit,
        "low": told.low if isfinite(told.low) else None,
        "high": told.high if isfinite(told.high) else None,
        "assumed": told.assumed,
        "live": told.live,
    }


def changed(settings: Settings, given: Mapping[str, object], *, live: bool = False) -> Settings:
    """The same settings with some given anew, each converted to the type of its field.

    Raises:
        UserError: an unknown name, a value of the wrong type or out of its range, or, with
            `live`, a setting that cannot change while the device runs.
    """
    types = _types(type(settings))  # type: ignore[arg-type]
    known = {entry.name: entry for entry in fields(settings)}  # type: ignore[arg-type]
    for name in given:
        if name not in known:
            raise unknown("setting", name, known)
        if live and not about(known[name]).live:
            raise UserError(f"setting {name!r} is taken over at power-on only")
    converted = {name: _convert(name, value, types[name]) for name, value in given.items()}
    for name, value in converted.items():
        _check_range(name, value, about(known[name]))
    return replace(settings, **converted)  # type: ignore[type-var]


@cache
def _types(settings: type) -> Mapping[str, Any]:
    """Of its fields; they are worked out from texts, which takes longer than all the rest."""
    return get_type_hints(settings)


def _convert(name: str, value: object, kind: Any) -> object:
    if get_origin(kind) is Literal:
        return _choice(name, value, get_args(kind))
    if isinstance(kind, UnionType):  # `int | None`
        if value is None or value == "none":
            return None
        kind = next(option for option in get_args(kind) if option is not type(None))
    return convert(f"setting {name!r}", value, kind)


def _check_range(name: str, value: object, told: About) -> None:
    if isinstance(value, (int, float)) and not told.low <= value <= told.high:
        raise UserError(f"setting {name!r} is {told.range}, not {value}")


def _choice(name: str, value: object, choices: tuple[object, ...]) -> object:
    if value not in choices:
        raise UserError(f"setting {name!r} is one of {', '.join(map(str, choices))}, not {value!r}")
    return value


@dataclass(frozen=True)
class TimingSettings:
    """Times of a real device, all assumed (docs/reference/timing.md).

    None is for what the preset says; see `canopen_twins.device.timing`.
    """

    timing: Literal["ideal", "typical", "worst"] = setting(
        "ideal",
        "preset of the times that are none; `run` has typical",
    )
    boot_time: float | None = setting(
        None, "from power-on, 81h and 82h to the boot-up message", unit="s", low=0
    )
    answer_time: float | None = setting(
        None, "from an SDO request to its answer", unit="s", low=0, high=60
    )
    answer_jitter: float | None = setting(
        None, "added to the answer time at most, by seed", unit="s", low=0, high=60
    )
    busy_request: Literal["overwrites", "waits"] = setting(
        "overwrites", "what a request does when one is answered and another waits already"
    )
    store_time: float | None = setting(
        None, "for which 0x1010 and 0x1011 are busy", unit="s", low=0, high=3600
    )
    store_busy: Literal["late", "refuses"] = setting(
        "late", "answered when it is stored, or at once and refused (06060000h) meanwhile"
    )
    measure_time: float | None = setting(
        None, "from one measured value to the next", unit="s", low=0, high=3600
    )
    noise: float | None = setting(
        None, "of measured values, up and down", unit="digits of the object", low=0
    )
    seed: int = setting(0, "of noise and jitter")


@dataclass(frozen=True)
class NodeSettings(TimingSettings):
    """The settings that every device has."""

    node_id: int = setting(1, "node id the device is delivered with, 1..127")
