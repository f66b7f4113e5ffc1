"""What a device file adds to a class: values that move, what is told of them, faults."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar, NamedTuple

from canopen.objectdictionary import ODVariable

from canopen_twins.device.chart import Chart, Curve
from canopen_twins.device.device import EmcyMessage, Message
from canopen_twins.device.faults import Fault
from canopen_twins.devices.eds.model import (
    Condition,
    Follower,
    Kind,
    Quantity,
    Ramp,
    Read,
    constant,
    rest,
    step,
)
from canopen_twins.devices.eds.settable import Settable
from canopen_twins.slave.emcy import Emcy
from canopen_twins.slave.object import Address, Object, Value

Source = float | str | Address
"""A number, the name of a setting, or an object."""


class Making(NamedTuple):
    """What a quantity is made of, beside what its file says."""

    start: float
    kind: Kind
    seed: str
    read: Callable[[Source], Read]


@dataclass(frozen=True)
class MovingValue:
    """An object whose value moves."""

    variable: ODVariable
    kind: Kind
    start: Source
    make: Callable[[Making], Quantity]
    unit: str = ""

    @property
    def address(self) -> Address:
        """Where it is."""
        return self.variable.index, self.variable.subindex

    @property
    def label(self) -> str:
        """Its name, for reports."""
        name: str = self.variable.qualname
        return f"{name} [{self.unit}]" if self.unit else name


class Comparison(NamedTuple):
    """What a value is compared with."""

    address: Address
    above: Source | None
    below: Source | None
    equals: Source | None


class Emergency(NamedTuple):
    """An EMCY that is active while all comparisons hold."""

    emcy: Emcy
    while_: Sequence[Comparison]


class Disorder(NamedTuple):
    """A fault of values."""

    text: str
    hold: Sequence[Address] = ()
    set: Mapping[Address, Source] = {}
    offset: Mapping[Address, Source] = {}


@dataclass(frozen=True)
class Told:
    """What a device file says of values."""

    values: Sequence[MovingValue] = ()
    emergencies: Sequence[Emergency] = ()
    faults: Mapping[str, Disorder] = field(default_factory=dict)
    initial: Mapping[Address, float] = field(default_factory=dict)
    """Of the objects that are read, before there is a dictionary in force."""


class Behaviour(Settable):
    """Stands before a class, and does what `told` says beside what that does."""

    told: ClassVar[Told] = Told()

    def make_model(self) -> None:
        """Values begin anew."""
        super().make_model()
        self.slave = None
        self._quantities: dict[Address, Quantity] = {}
        self._to_make = {value.address: value for value in self.told.values}
        while self._to_make:
            self._make(next(iter(self._to_make)))
        self._conditions = [
            (emergency.emcy, [self._condition(each) for each in emergency.while_])
            for emergency in self.told.emergencies
        ]

    @property
    def objects(self) -> Mapping[Address, Object]:
        """Those of the class, and values in their place."""
        return {
            **super().objects,
            **{value.address: self._object(value) for value in self.told.values},
        }

    @property
    def emergencies(self) -> Sequence[Emcy]:
        """Those of the class, then those of the file in its order."""
        active = [
            emcy
            for emcy, conditions in self._conditions
            if all(condition.holds for condition in conditions)
        ]
        return (*super().emergencies, *active)

    @property
    def faults(self) -> Mapping[str, Fault]:
        """Those of the class, and those of the file."""
        ours = {
            name: Fault(
                disorder.text,
                partial(self._disturb, name, disorder, self._quantities),
                partial(self._mend, name, self._quantities.values()),
            )
            for name, disorder in self.told.faults.items()
        }
        return {**super().faults, **ours}

    @property
    def messages(self) -> Mapping[str, Message]:
        """Those of the class, and the emergencies of the file by their names."""
        ours = {
            each.emcy.label: EmcyMessage(each.emcy.label, each.emcy.code, each.emcy.field)
            for each in self.told.emergencies
        }
        return {**super().messages, **ours}

    @property
    def report(self) -> Mapping[str, object]:
        """That of the class, and readings with their units."""
        readings = {
            value.label: self._quantities[value.address].reading for value in self.told.values
        }
        return {**super().report, **readings}

    @property
    def chart(self) -> Chart:
        """That of the class, and a curve for each value, beside what it goes to."""
        chart = super().chart
        return chart._replace(curves=[*chart.curves, *map(self._curve, self.told.values)])

    @property
    def rest(self) -> float:
        """Until something moves."""
        return min(super().rest, rest(self._quantities.values()))

    def step(self, dt: float) -> None:
        """Let time pass for both."""
        super().step(dt)
        step(self._quantities.values(), dt)

    def reset_node(self) -> None:
        """What a master may write is as after power-on; what is measured goes on."""
        super().reset_node()
        for value in self.told.values:
            if value.variable.writable:
                self._quantities[value.address].put(self._read(value.start)())

    def put(self, variable: ODVariable, value: Value) -> None:
        """A value that moves moves on from there."""
        quantity = self._quantities.get((variable.index, variable.subindex))
        if quantity is None or isinstance(value, (str, bytes)):
            super().put(variable, value)
        else:
            quantity.put(value)

    def _make(self, address: Address) -> None:
        """A value begins where others are, so that these are made before it."""
        value = self._to_make.pop(address)
        seed = f"{getattr(self.settings, 'seed', 0)} {value.variable.qualname}"
        making = Making(self._read(value.start)(), value.kind, seed, self._read)
        self._quantities[address] = value.make(making)

    def _object(self, value: MovingValue) -> Object:
        quantity = self._quantities[value.address]
        return Object(read=lambda: quantity.reading, write=quantity.put)

    def _curve(self, value: MovingValue) -> Curve:
        quantity = self._quantities[value.address]
        aim = quantity.aim if isinstance(quantity, (Follower, Ramp)) else None
        return Curve(value.variable.qualname, value.unit, lambda: quantity.reading, aim)

    def _read(self, source: Source) -> Read:
        if isinstance(source, str):
            return lambda: float(getattr(self.settings, source))
        return constant(source) if isinstance(source, (int, float)) else partial(self._now, source)

    def _now(self, address: Address) -> float:
        """What an object reads."""
        if address in self._to_make:
            self._make(address)
        if (quantity := self._quantities.get(address)) is not None:
            return quantity.reading
        if self.slave is None or not self.slave.has(*address):
            return self.told.initial[address]
        entry = self.slave.entry(*address)
        return float(entry.unpack(entry.read()))

    def _condition(self, told: Comparison) -> Condition:
        ends = (None if end is None else self._read(end) for end in told[1:])
        return Condition(self._read(told.address), *ends)

    def _disturb(self, name: str, told: Disorder, quantities: Mapping[Address, Quantity]) -> None:
        for address in told.hold:
            quantities[address].holds.add(name)
        for address, source in told.set.items():
            quantities[address].replaced[name] = self._read(source)()
        for address, source in told.offset.items():
            quantities[address].offsets[name] = self._read(source)()

    @staticmethod
    def _mend(name: str, quantities: Iterable[Quantity]) -> None:
        for quantity in quantities:
            quantity.holds.discard(name)
            quantity.replaced.pop(name, None)
            quantity.offsets.pop(name, None)
