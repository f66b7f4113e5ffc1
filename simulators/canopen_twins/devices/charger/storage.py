"""What the charger keeps without supply: parameters, node id and bit timing, hour counters."""

import logging
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

from canopen.objectdictionary import ODVariable

from canopen_twins.device import Memory
from canopen_twins.devices.charger.communication import Place, fits
from canopen_twins.devices.charger.model.parameters import LIMITS, Parameter
from canopen_twins.devices.charger.model.ticks import Hours

log = logging.getLogger(__name__)

PARAMETERS, NETWORK, HOURS = "charger parameters", "network", "hours"
NOT_STORED = Parameter.KEYBOARD_LOCK  # 2002h:1Ch

Values = Mapping[str, int]
Check = Callable[[Values], bool]


class Storage:
    """Named numbers in the sections of a memory; what is damaged is reported and left out."""

    def __init__(self, memory: Memory, entries: Mapping[int, ODVariable]) -> None:
        """`entries` are those of 2002h: which parameters there are, and their limits."""
        self._memory = memory
        self._entries = entries

    def parameters(self, factory: Mapping[Parameter, int]) -> Mapping[Parameter, int]:
        """As they were saved; those of the factory if they never were."""
        kept = {p.name: value for p, value in factory.items() if self._keeps(p)}
        stored = self._recall(PARAMETERS, kept, self._are_parameters)
        return {**factory, **{Parameter[name]: value for name, value in stored.items()}}

    def save_parameters(self, value: Callable[[Parameter], int]) -> None:
        """Keep those the dictionary has. Raises OSError if the memory cannot be written."""
        values = {p.name: value(p) for p in Parameter if self._keeps(p)}
        self._memory.store(PARAMETERS, values)

    def forget_parameters(self) -> None:
        """Keep those of the factory. Raises OSError if the memory cannot be written."""
        self._memory.store(PARAMETERS, {})

    def place(self, factory: Place) -> Place:
        """Node id and bit timing as they were stored."""
        stored = self._recall(NETWORK, factory._asdict(), lambda v: fits(**v))
        return Place(**stored)

    def save_place(self, place: Place) -> None:
        """Raises OSError if the memory cannot be written."""
        self._memory.store(NETWORK, place._asdict())

    def hours(self, delivered: Hours) -> Hours:
        """The hour counters as they were when the supply went, or as `delivered`."""
        return Hours(**self._recall(HOURS, asdict(delivered), lambda v: min(v.values()) >= 0))

    def save_hours(self, hours: Hours) -> None:
        """A memory that fails loses them: nobody has asked who could be told."""
        try:
            self._memory.store(HOURS, vars(hours).copy())
        except OSError as failure:
            log.error("the hour counters cannot be stored: %s", failure)

    def _recall(self, section: str, factory: Values, check: Check) -> Values:
        stored = self._memory.load(section)
        values = {**factory, **stored}
        whole = all(type(value) is int for value in values.values())
        if whole and values.keys() == factory.keys() and check(values):
            return values
        log.error("stored %s is left out, it is none of this charger: %s", section, stored)
        return factory

    def _keeps(self, parameter: Parameter) -> bool:
        return parameter in self._entries and parameter is not NOT_STORED

    def _are_parameters(self, values: Values) -> bool:
        """Whether each is inside its limits, which may be other parameters."""
        named = {Parameter[name]: value for name, value in values.items()}
        return all(self._fits(parameter, named) for parameter in named)

    def _fits(self, parameter: Parameter, values: Mapping[Parameter, int]) -> bool:
        low, high = LIMITS.get(parameter, (None, None))
        entry: Any = self._entries[parameter]
        lowest = entry.min if low is None else values[low]
        highest = entry.max if high is None else values[high]
        return bool(lowest <= values[parameter] <= highest)
