"""What can go wrong: one vocabulary for scenarios, tests and the command line."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from simulators.errors import UserError, unknown
from simulators.kinds import convert


@dataclass(frozen=True)
class Parameter:
    """One parameter of a fault: what it means, and its value when nobody says otherwise.

    A parameter without default has to be given.
    """

    text: str
    default: int | float | str | None = None
    kind: type[int] | type[float] | type[str] = float


@dataclass(frozen=True)
class Fault:
    """Something that can be injected and cleared by name.

    `inject` is called with every parameter as a keyword, `clear` later with the same. A fault
    without `clear` is over at once: what it leaves behind is the device's to reset.
    """

    text: str
    inject: Callable[..., None]
    clear: Callable[..., None] | None = None
    parameters: Mapping[str, Parameter] = field(default_factory=dict)


class Faults:
    """The faults of one device, and which of them are active."""

    def __init__(self, known: Mapping[str, Fault]) -> None:
        self.known = known
        self.active: dict[str, dict[str, Any]] = {}

    def inject(self, name: str, **given: Any) -> None:
        """Let something go wrong; a fault that is active already is replaced.

        Raises:
            UserError: no such fault, an unknown or missing parameter, or a wrong value.
        """
        fault = self._find(name)
        values = arguments(name, fault, given)
        self.clear(name)
        fault.inject(**values)
        if fault.clear is not None:
            self.active[name] = values

    def clear(self, name: str | None = None) -> None:
        """Take one fault away, or all of them; the device recovers as far as it does by itself.

        Raises:
            UserError: no such fault.
        """
        for each in [name] if name is not None else list(self.active):
            fault = self._find(each)
            values = self.active.pop(each, None)
            if values is not None and fault.clear is not None:
                fault.clear(**values)

    def renew(self) -> None:
        """Inject again what is active: a cause outlives the power cycle of the device."""
        for name, values in self.active.items():
            self.known[name].inject(**values)

    def _find(self, name: str) -> Fault:
        if name not in self.known:
            raise unknown("fault", name, self.known)
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
        UserError: the fault has no such parameter, or the value is of the wrong kind.
    """
    if parameter not in fault.parameters:
        raise unknown(f"parameter of fault {name!r}", parameter, fault.parameters)
    kind = fault.parameters[parameter].kind
    return convert(f"parameter {parameter!r} of fault {name!r}", value, kind)
