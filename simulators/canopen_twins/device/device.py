"""What a twin is made of: a device with its model, its objects, and what it does on the bus."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields
from functools import cache
from math import inf
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from canopen import ObjectDictionary

from canopen_twins.bus.identifiers import NODE_IDS
from canopen_twins.device.chart import Chart
from canopen_twins.device.faults import Fault
from canopen_twins.device.settings import NodeSettings, changed
from canopen_twins.device.timing import PRESETS, Timing, timing_of
from canopen_twins.errors import UserError
from canopen_twins.files.shipped import od_file
from canopen_twins.slave.dictionary import dictionary
from canopen_twins.slave.emcy import Emcy, Farewell, when_all_are_gone
from canopen_twins.slave.memory import Memory
from canopen_twins.slave.object import Address, Object, Rejected
from canopen_twins.slave.profile import Profile
from canopen_twins.slave.rpdo import Rpdo
from canopen_twins.slave.service import Service, State
from canopen_twins.slave.slave import Slave
from canopen_twins.slave.tpdo import Tpdo


class EmcyMessage(NamedTuple):
    """An emergency."""

    text: str
    code: int
    """Emergency error code."""
    field: bytes = b""
    """How the manufacturer-specific error field begins; empty for whatever it is."""


class BitMessage(NamedTuple):
    """A bit of an object; set while there is something to tell."""

    text: str
    address: Address
    bit: int


Message = EmcyMessage | BitMessage


class Device:
    """A model, the dictionary in front of it, and what it does on the bus.

    A class names its `eds` and its `title`, and makes its model in `make_model`, which is called
    when the device is made and configured, so that there is a model without power as well.
    Commands come from the node in this order: `power_on`, then `on_state`, `step` and writes to
    objects as they happen, `reset_node` and `reset_communication` when the NMT master says so, and
    `power_off`, after which time passes in `step_unpowered`.

    Raises:
        UserError: settings that are unknown or of the wrong kind.
    """

    eds: str
    """File of od/, or a path."""
    title: ClassVar[str]
    """Maker, name and manual, for lists."""
    settings: Any = NodeSettings()
    """The defaults, a frozen dataclass; a class names its own, `settings = MySettings()`."""
    profile: Profile = Profile()
    cycle: float = 0.01
    """Seconds between two steps, whole microseconds."""
    files: tuple[Path, ...] = ()
    """Those that describe it, first the one it is named by; none for a class of Python."""
    timings: ClassVar[Mapping[str, Timing]] = PRESETS
    """What the presets of `timing` are; a class names its own where its maker tells them."""

    def __init__(self, **given: object) -> None:
        self.memory = Memory()
        self.configure(**given)

    @classmethod
    @cache
    def complete(cls) -> None:
        """Look at what its author has written, before it is listed and before it has power.

        Raises:
            UserError: it has no title or no EDS, or there is no such file.
        """
        for name, example in (("title", "Maker, name (manual)"), ("eds", "fan.eds")):
            if not isinstance(getattr(cls, name, None), str):
                raise UserError(f'{cls.__name__} has no {name}: write {name} = "{example}"')
        with od_file(cls.eds) as path:
            if not path.is_file():
                raise UserError(f"{cls.__name__}: there is no EDS {path}; eds is a path to one")

    @property
    def node_id(self) -> int:
        """The node id to boot with; asked at power-on and at every reset."""
        return int(self.settings.node_id)

    @property
    def bit_rate(self) -> int | None:
        """In force, in bit/s; none if it has none, or one that never is wrong."""
        return None

    @property
    def timing(self) -> Timing:
        """How long it takes for things; asked at power-on and at every reset."""
        return timing_of(self.settings, self.timings)

    @property
    def online(self) -> bool:
        """Whether there is anything on the bus: firmware, or whatever lies behind it."""
        return True

    @property
    def silence(self) -> str:
        """Why it is not `online`, in words for whoever waits for it."""
        return ""

    @property
    def nmt_state(self) -> State | None:
        """The NMT state the device is in by its own will; none where the master decides."""
        return None

    @property
    def rest(self) -> float:
        """Seconds from the last step during which stepping may be left out.

        Nothing that can be observed changes meanwhile unless somebody acts; 0 for every cycle.
        """
        return inf

    @property
    def objects(self) -> Mapping[Address, Object]:
        """The entries that act on the model."""
        return {}

    @property
    def measured(self) -> Collection[Address]:
        """The entries whose values are measured: they have a refresh cycle, and noise."""
        return ()

    @property
    def ranges(self) -> Mapping[str, tuple[int, int]]:
        """Measured whole numbers that `set` takes, by name: the least and the greatest."""
        return {}

    @property
    def stored(self) -> Collection[Address]:
        """The entries that 0x1010 keeps."""
        return ()

    @property
    def emergencies(self) -> Sequence[Emcy]:
        """What is wrong at this moment, in the order in which it came."""
        return ()

    @property
    def faults(self) -> Mapping[str, Fault]:
        """What can be injected."""
        return {}

    @property
    def has_emergencies(self) -> bool:
        """Whether it has any at all, so that one of them can go wrong."""
        return True

    @property
    def messages(self) -> Mapping[str, Message]:
        """What a master can be told, by the names of the manual and in its order."""
        return {}

    @property
    def report(self) -> Mapping[str, object]:
        """What a look at the model shows, in engineering units, for traces and failed tests."""
        return {}

    @property
    def chart(self) -> Chart:
        """What is drawn in a picture of a run; asked for whenever somebody looks."""
        return Chart()

    farewell: Farewell = staticmethod(when_all_are_gone)
    """What is told of an error that has gone."""

    def dictionary(self) -> ObjectDictionary:
        """A fresh object dictionary for the slave that is about to boot."""
        return dictionary(self.eds, self.node_id)

    def pdos(self, slave: Slave) -> Iterable[Service]:
        """The PDOs of the dictionary, and what may drive them."""
        yield from (Rpdo(slave, number, self.on_rpdo_refused) for number in Rpdo.numbers(slave))
        yield from (Tpdo(slave, number) for number in Tpdo.numbers(slave))

    def services(self, slave: Slave) -> Iterable[Service]:
        """What this device does on the bus beyond the standard services."""
        return ()

    def make_model(self) -> None:
        """Make the model from the settings, with all that outlives the supply as it is at first."""

    def power_on(self) -> None:
        """Supply comes: all that is volatile is made anew, by default the whole model.

        A device with energy that outlives the supply keeps what holds it and renews the rest.
        """
        self.make_model()

    def power_off(self) -> None:
        """Supply goes."""

    def step_unpowered(self, dt: float) -> None:
        """Let time pass in what outlives the supply: a capacitor, heat, what is connected.

        `dt` is a whole number of cycles, in seconds. It comes when somebody looks, acts on the
        device or switches it on, so all the time without supply may be one step.
        """

    def reset_node(self) -> None:
        """NMT 81h: the application starts afresh."""

    def reset_communication(self) -> None:
        """NMT 82h: only the communication starts afresh."""

    def save(self) -> None:
        """0x1010: keep in the memory what is not among `stored`.

        Raises:
            OSError: the memory cannot be written; the master is told.
        """

    def restore(self) -> None:
        """0x1011: keep the factory settings of the same; raises as `save` does."""

    def on_state(self, state: State) -> None:
        """The node has entered an NMT state."""

    def on_frame(self) -> None:
        """A frame that this node listens to has come; what that changes is told after it."""

    def on_heartbeat(self, node_id: int, alive: bool) -> None:
        """A node that 0x1016 watches has fallen silent, or is back."""

    def on_emcy(self, node_id: int, emcy: Emcy) -> None:
        """A node that 0x1028 names has told an emergency."""

    def on_request_lost(self) -> None:
        """An SDO request has found no room among those that wait, where they do."""

    def on_rpdo_refused(self, number: int, refusal: Rejected) -> None:
        """An RPDO was too short, or brought a value that an object refused."""

    def knows(self, name: str) -> bool:
        """Whether `set` takes something of this name."""
        return name in {field.name for field in fields(self.settings)}

    def current(self, name: str) -> Any:
        """What `set` takes for this name to stay as it is."""
        return getattr(self.settings, name)

    def set_back(self, /, **before: object) -> None:
        """Let be what was `current` before; raises as `set` does."""
        self.set(**before)

    def set(self, /, **given: object) -> None:
        """Change settings while the device runs.

        Raises:
            UserError: unknown, of the wrong kind, taken over at power-on only, or not to go
                together; the settings are then as before.
        """
        with self._trial(given, live=True):
            self.apply()

    def configure(self, /, **given: object) -> None:
        """Change settings while the device is off; raises as `set` does."""
        with self._trial(given):
            self.make_model()

    @contextmanager
    def _trial(self, given: Mapping[str, object], live: bool = False) -> Iterator[None]:
        before, self.settings = self.settings, changed(self.settings, given, live=live)
        try:
            self.check()
            yield
        except UserError:
            self.settings = before
            raise

    def check(self) -> None:
        """Look at the settings as a whole, before they are taken over.

        Raises:
            UserError: right one by one, but not together; a node id outside 1..127.
        """
        if self.node_id not in NODE_IDS:
            raise UserError(f"node id {self.node_id} is not in 1..127")

    def apply(self) -> None:
        """Take over settings that have changed while the device runs."""

    def step(self, dt: float) -> None:
        """Let time pass in the model; `dt` is a whole number of cycles, in seconds."""
