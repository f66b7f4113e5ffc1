"""Device files as classes: names and numbers are looked up in the EDS when the file is read."""

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, make_dataclass, replace
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import FLOAT_TYPES

from canopen_twins.device.device import Device
from canopen_twins.device.settings import setting
from canopen_twins.devices import eds
from canopen_twins.devices.eds import device_file, model
from canopen_twins.devices.eds.behaviour import (
    Behaviour,
    Comparison,
    Disorder,
    Emergency,
    Making,
    MovingValue,
    Source,
    Told,
)
from canopen_twins.devices.eds.samples import read_samples
from canopen_twins.devices.eds.settable import bounds
from canopen_twins.errors import UserError, unknown
from canopen_twins.files.document import Item, Reported
from canopen_twins.files.table import understand_table
from canopen_twins.slave.dictionary import Objects, address_text
from canopen_twins.slave.emcy import FIELD_LENGTH, Emcy
from canopen_twins.slave.object import Address

APPLICATION = 0x2000


def device_of(path: Path) -> type[Device]:
    """The device of a device file; what is unusual in its EDS is logged once.

    Raises:
        DocumentError: with a line for everything that is wrong.
    """
    kind = described(path)
    eds.device_of(Path(kind.eds))
    return kind


def described(path: Path) -> type[Device]:
    """The same for whoever tells the remarks on its EDS in another way."""
    place = path.absolute()
    if place in READ and READ[place].is_current:
        return READ[place].device
    device = understand_table(
        path, device_file.DeviceFile, lambda file: Compiler(file, path).device
    )
    READ[place] = Reading(device, _changed(device.files))
    return device


class Reading(NamedTuple):
    """A device, and when each of its files had been changed."""

    device: type[Device]
    changed: Sequence[int]

    @property
    def is_current(self) -> bool:
        """Whether all of its files are as they were."""
        return self.changed == _changed(self.device.files)


READ: dict[Path, Reading] = {}


def _changed(files: Sequence[Path]) -> Sequence[int]:
    return [file.stat().st_mtime_ns if file.exists() else 0 for file in files]


class Compiler:
    """Takes one file; what is wrong with a part of it becomes a problem."""

    def __init__(self, file: device_file.DeviceFile, path: Path) -> None:
        self.file = file
        self.path = path
        self.files = [path.absolute()]
        with file.eds.blamed():
            self._described = eds.described(path.parent / file.eds.text)
        self.files += self._described.files
        self.base = self._described if file.python is None else self._class(file.python)
        self.objects = Objects(self._described().dictionary())
        self.initial: dict[Address, float] = {}
        self._settings = {
            **{entry.name: 0.0 for entry in fields(self.base.settings)},
            **{name.text: table.default for name, table in (file.settings or {}).items() if table},
        }

    @property
    def device(self) -> type[Device]:
        """The class: what the file says, in front of what the EDS or Python say."""
        values = dict(self._values())
        emergencies = list(self._emergencies())
        faults = dict(self._faults(values))
        settings = self._all_settings()
        given = self.file.profile.model_dump(exclude_none=True) if self.file.profile else {}
        return type(
            self.path.name.removesuffix(self.path.suffix).removesuffix(".device"),
            (Behaviour, self.base),
            {
                **_told_by_eds(self._described),
                "__module__": __name__,
                "__doc__": f"The device of {self.path.name}.",
                "title": self.file.title or getattr(self.base, "title", self._described.title),
                "settings": settings,
                "profile": replace(self.base.profile, **given),
                "files": tuple(self.files),
                "told": Told([*values.values()], emergencies, faults, self.initial),
            },
        )

    # Names and numbers

    def object(self, name: Item) -> tuple[Address, ODVariable]:
        """A number in the dictionary.

        Raises:
            UserError: there is no such object, or it is no number.
        """
        with name.blamed():
            variable = self.objects.find(name.text)
            address = variable.index, variable.subindex
            if bounds(variable) is None:
                raise UserError(f"{variable.qualname!r} is no number")
        value = variable.default if variable.value is None else variable.value
        self.initial[address] = float(value or 0)
        return address, variable

    def moved(self, name: Item) -> tuple[Address, ODVariable]:
        """One that the application has, so that it can move; raises as `object` does."""
        address, variable = self.object(name)
        if address[0] < APPLICATION:
            raise name.wrong(
                f"{address_text(address)} is of the communication, which has it itself"
            )
        return address, variable

    def source(self, item: Item) -> Source:
        """A number, a setting, or an object; raises as `object` does."""
        if not isinstance(item.value, str) or item.text in self._settings:
            return self.chosen(item)
        if item.text not in self.objects and not item.text.startswith("0x"):
            raise item.wrong(
                str(unknown("setting or object", item.text, {*self._settings, *self.objects}))
            )
        return self.object(item)[0]

    def chosen(self, item: Item | None, default: float = 0.0, least: float | None = None) -> Source:
        """A number or a setting; `least` of a number.

        Raises:
            UserError: there is no such setting, or it is less.
        """
        if item is None:
            return default
        if isinstance(item.value, str):
            return item.one_of("setting", self._settings)
        if least is not None and item.number < least:
            raise item.wrong(f"{item.text} is less than {least:g}")
        return float(item.number)

    # Settings and the class

    def _all_settings(self) -> Any:
        """Those of the class with those of the file."""
        names = {entry.name for entry in fields(self.base.settings)}
        added: list[tuple[str, type, Any]] = []
        for name, table in (self.file.settings or {}).items():
            with name.problems.at(name):
                if name.text in names:
                    raise name.wrong(f"every device of this kind has a setting {name.text!r}")
                if name.text in self.objects:
                    raise name.wrong(f"{name.text!r} is the name of an object, too: take another")
                if table is not None:
                    added.append((name.text, float, _setting(table)))
        before = self.base.settings
        kept = {entry.name: getattr(before, entry.name) for entry in fields(before)}
        if self._described.settings.node_id != before.node_id:
            kept["node_id"] = self._described.settings.node_id
        return make_dataclass("Settings", added, bases=(type(before),), frozen=True)(**kept)

    def _class(self, name: Item) -> type[Device]:
        module, _, word = name.text.partition(":")
        if not word:
            raise name.wrong(f"{name.text!r} is no module:Class, such as fan:Fan")
        try:
            found = getattr(self._module(module), word)
        except (ImportError, AttributeError, SyntaxError) as failure:
            raise name.wrong(f"{name.text}: {failure}") from failure
        if not (isinstance(found, type) and issubclass(found, Device)):
            raise name.wrong(f"{name.text} is no Device")
        return found

    def _module(self, name: str) -> ModuleType:
        """One beside the file, before those that are installed."""
        beside = self.path.absolute().with_name(f"{name}.py")
        if not beside.is_file():
            return import_module(name)
        self.files.append(beside)
        spec = spec_from_file_location(f"{name} of {beside.parent}", beside)
        if spec is None or spec.loader is None:
            raise ImportError(f"{beside} cannot be imported")
        module = sys.modules[spec.name] = module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    # Values

    def _values(self) -> Iterator[tuple[Address, MovingValue]]:
        seen: dict[Address, Item] = {}
        for name, table in (self.file.values or {}).items():
            with name.problems.at(name):
                address, variable = self.moved(name)
                first = seen.setdefault(address, name)
                if first is not name:
                    raise name.wrong(f"line {first.line} says already how this object moves")
                if table is not None:
                    yield address, self._value(variable, table)

    def _value(self, variable: ODVariable, table: device_file.ValueTable) -> MovingValue:
        kind = next((kind for kind in MAKES if getattr(table, kind) is not None), None)
        if kind is None:
            raise Reported
        initial = self.initial[variable.index, variable.subindex]
        start = self.chosen(table.start or table.value, initial)
        make = MAKES[kind](table, self)
        return MovingValue(variable, _kind(variable), start, make, table.unit)

    def samples(self, table: device_file.ValueTable) -> list[model.Sample]:
        """The rows of a CSV file.

        Raises:
            UserError: it cannot be read, or a row is wrong.
        """
        place = table.item_of("replays")
        path = self.path.parent / place.text
        with place.blamed():
            samples = read_samples(path, table.column)
            if table.repeat and not samples[-1].time:
                raise UserError(f"{path.name}: there is no time in it that could repeat")
        if path.absolute() not in self.files:
            self.files.append(path.absolute())
        return samples

    # Emergencies and faults

    def _emergencies(self) -> Iterator[Emergency]:
        for name, table in (self.file.emergencies or {}).items():
            if table is None:
                continue
            told = []
            for what, comparison in table.condition.items():
                with what.problems.at(what):
                    ends = (comparison.above, comparison.below, comparison.equals)
                    address = self.object(what)[0]
                    told.append(
                        Comparison(
                            address, *(None if end is None else self.source(end) for end in ends)
                        )
                    )
            content = table.detail.to_bytes(FIELD_LENGTH, "little")
            yield Emergency(Emcy(table.code, table.bits, content, name.text), told)

    def _faults(self, values: dict[Address, MovingValue]) -> Iterator[tuple[str, Disorder]]:
        for name, table in (self.file.faults or {}).items():
            if table is not None:
                yield (
                    name.text,
                    Disorder(
                        table.text,
                        [*self._held(table, values)],
                        dict(self._disturbed(table.set, values)),
                        dict(self._disturbed(table.offset, values)),
                    ),
                )

    def _held(
        self, table: device_file.FaultTable, values: Mapping[Address, MovingValue]
    ) -> Iterator[Address]:
        for name in table.hold or []:
            with name.problems.at(name):
                address, variable = self.moved(name)
                if address not in values:
                    raise name.wrong(f"{variable.qualname!r} is not among the values that move")
                yield address

    def _disturbed(
        self, given: Mapping[Item, Item] | None, values: dict[Address, MovingValue]
    ) -> Iterator[tuple[Address, Source]]:
        """An object that does not move gets a value that stays, so that it can be disturbed."""
        for name, number in (given or {}).items():
            with name.problems.at(name):
                address, variable = self.moved(name)
                if address not in values:
                    start = self.initial[address]
                    values[address] = MovingValue(
                        variable, _kind(variable), start, _constant(start)
                    )
                yield address, self.chosen(number)


def _told_by_eds(kind: type[Device]) -> Mapping[str, Any]:
    return {key: value for key, value in vars(kind).items() if not key.startswith("__")}


def _setting(table: device_file.SettingTable) -> Any:
    ends = {key: end for key in ("low", "high") if (end := getattr(table, key)) is not None}
    default = table.default
    if not ends.get("low", default) <= default <= ends.get("high", default):
        raise table.item_of("default").wrong(f"{default:g} is not between low and high")
    return setting(default, table.text, unit=table.unit, live=True, **ends)


def _kind(variable: ODVariable) -> model.Kind:
    low, high = bounds(variable) or (0, 0)
    return model.Kind(variable.data_type not in FLOAT_TYPES, low, high)


# How each kind of value is made: called with its table and the compiler, makes what makes it

Make = Callable[[Making], model.Quantity]
Table = device_file.ValueTable


def _constant(number: float) -> Make:
    zero = model.constant(0.0)
    return lambda of: model.Noisy(
        of.start, of.kind, model.constant(1.0), model.constant(number), zero, of.seed
    )


def _noisy(table: Table, find: Compiler) -> Make:
    base, noise = find.chosen(table.value), find.chosen(table.noise, least=0)
    every = _every(table, find)
    return lambda of: model.Noisy(
        of.start, of.kind, of.read(every), of.read(base), of.read(noise), of.seed
    )


def _follower(table: Table, find: Compiler) -> Make:
    linear = _linear(table.follows, table, find)
    time_constant = find.chosen(table.time_constant, least=0)

    def made(of: Making) -> model.Quantity:
        aim = linear(of)
        start = aim() if table.start is None else of.start
        return model.Follower(start, of.kind, aim, of.read(time_constant))

    return made


def _ramp(table: Table, find: Compiler) -> Make:
    aim, rate = _linear(table.ramps, table, find), find.chosen(table.rate, least=0)
    return lambda of: model.Ramp(of.start, of.kind, aim(of), of.read(rate))


def _integral(table: Table, find: Compiler) -> Make:
    speed, ends = _linear(table.integrates, table, find), _ends(table, find)
    return lambda of: model.Integral(of.start, of.kind, speed(of), *ends(of))


def _counter(table: Table, find: Compiler) -> Make:
    amount, every, ends = find.chosen(table.counts), _every(table, find), _ends(table, find)
    return lambda of: model.Counter(of.start, of.kind, of.read(every), of.read(amount), *ends(of))


def _wanderer(table: Table, find: Compiler) -> Make:
    most, every = find.chosen(table.wanders, least=0), _every(table, find)
    ends = _ends(table, find)
    return lambda of: model.Wanderer(
        of.start, of.kind, of.read(every), of.read(most), *ends(of), of.seed
    )


def _replay(table: Table, find: Compiler) -> Make:
    samples, repeat = find.samples(table), table.repeat
    return lambda of: model.Replay(of.start, of.kind, samples, repeat)


MAKES: Mapping[str, Callable[[Table, Compiler], Make]] = {
    "value": _noisy,
    "follows": _follower,
    "ramps": _ramp,
    "integrates": _integral,
    "counts": _counter,
    "wanders": _wanderer,
    "replays": _replay,
}


def _every(table: Table, find: Compiler) -> Source:
    return find.chosen(table.every, device_file.EVERY, least=0.01)


def _linear(item: Item | None, table: Table, find: Compiler) -> Callable[[Making], model.Read]:
    """What it goes by: a source times `gain`, plus `offset`."""
    if item is None:
        raise Reported
    source = find.source(item)
    gain, offset = find.chosen(table.gain, 1.0), find.chosen(table.offset)

    def made(of: Making) -> model.Read:
        read, times, plus = of.read(source), of.read(gain), of.read(offset)
        return lambda: read() * times() + plus()

    return made


def _ends(table: Table, find: Compiler) -> Callable[[Making], tuple[model.Read, model.Read]]:
    low = None if table.low is None else find.chosen(table.low)
    high = None if table.high is None else find.chosen(table.high)

    def made(of: Making) -> tuple[model.Read, model.Read]:
        ends = (of.kind.low if low is None else low, of.kind.high if high is None else high)
        return of.read(ends[0]), of.read(ends[1])

    return made
