"""What can go wrong in runs of a contract, and when: as the catalogue declares it, simple first.

Moments are those of the run without any fault: a fault is bound to an event rather than to a time,
so that it is still there when something before it has changed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, permutations, product
from math import inf, isfinite
from typing import Any, NamedTuple, TypeVar

from canopen_twins.bus.segment import Segment
from canopen_twins.device.faults import WEATHERS, Fault, Parameter
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.faults import connect
from canopen_twins.files.writer import Verbatim
from canopen_twins.hunt.contract import Disturbance, Plan
from canopen_twins.hunt.events import Events
from canopen_twins.hunt.settable import changes, deliveries
from canopen_twins.hunt.waits import NEXT, Wait
from canopen_twins.scenario import Scenario
from canopen_twins.scenario.compile import ARBITRATION


class Limits(NamedTuple):
    """How much goes wrong in a weather."""

    most: int
    """Faults in one run."""
    longest: float
    """Seconds of one of them."""
    losses: int
    """In a row, of frames or accesses."""
    heals: bool
    """Whether all of them do."""


Item = TypeVar("Item")

LIMITS: Mapping[str, Limits] = {
    "mild": Limits(1, 0.2, 1, heals=True),
    "rough": Limits(2, 2.0, 3, heals=True),
    "hostile": Limits(3, 10.0, 10, heals=False),
}
TIMES = (0.01, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
"""Round ones, of faults and for moments."""
MOMENTS = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
OF_TIME = ("seconds", "pause")
BY_AIM = ("nth", "probability", "burst", "seed", "frame")
MOST_ORDERS = 23  # those of four nodes
MOST_WORDS, MOST_OBJECTS, MOST_WAITS = 3, 16, 3
AIMS = 6
"""Of one fault, which are tried one after the other; its others are tried beside them."""
HEX = ("code", "number", "cob_id", "value")


@dataclass(frozen=True)
class Option:
    """One fault of one node, with all that it can be given."""

    node: str
    named: bool
    """Whether a file has to say which node."""
    fault: str
    parameters: tuple[Mapping[str, Any], ...]
    """Simple first."""
    aims: tuple[Mapping[str, Any], ...]
    """The same at one frame or one access each: those of the run without any fault."""
    delay: str
    """The parameter that says how late an answer is; empty if none does."""
    lengths: tuple[float | None, ...]
    """Seconds; None: as long as it takes to be struck, or until everything heals."""

    def at(self, moment: Disturbance, parameters: Mapping[str, Any], length: float | None) -> Any:
        """It, as a file has it."""
        inject: Any = {self.fault: dict(parameters)} if parameters else self.fault
        told = {**moment, **({"node": self.node} if self.named else {}), "inject": inject}
        return told if length is None else {**told, "for": length}


class Space:
    """What can go wrong with a scenario whose events are known."""

    def __init__(self, scenario: Scenario, events: Events) -> None:
        self.events = events
        said = scenario.space
        self.limits = LIMITS[said.weather]
        if said.most is not None:
            self.limits = self.limits._replace(most=said.most)
        self._scenario = scenario
        self._end = scenario.duration if scenario.recovers else events.seconds
        self.left_out: dict[str, str] = {}
        """Faults that cannot be tried, and why."""
        devices = {name: spec.create() for name, spec in scenario.nodes.items()}
        bus: Segment[Node] = Segment()
        self._nodes = {name: connect(bus, device, name) for name, device in devices.items()}
        self._several = len(devices) > 1
        self.options = [option for name in self._nodes for option in self._options(name)]
        self.moments = {name: list(self._moments(name)) for name in self._nodes}
        self.changes = [
            (name, *change)
            for name, node in self._nodes.items()
            for change in changes(scenario, name, node.device)
        ]
        self.orders = [*islice(permutations(self._nodes), 1, 1 + MOST_ORDERS)]
        self.orders.reverse()  # the last ones differ most
        """Other orders of the nodes: who comes first where frames are of one microsecond."""
        names = (*ARBITRATION, *self._nodes)
        self.arbitrations = [name for name in names if name != scenario.arbitration]
        """Who else may be on the bus first where several send at one microsecond."""
        self.deliveries = [
            (name, *each)
            for name, node in self._nodes.items()
            for each in deliveries(scenario, node.device)
        ]

    @property
    def faults(self) -> list[str]:
        """By name, those that are tried."""
        return list(dict.fromkeys(option.fault for option in self.options))

    def at_delivery(self) -> Iterator[Plan]:
        """What is different from the beginning on, one by one."""
        yield from (Plan(order=order) for order in self.orders[:1])
        yield from (Plan(settings=(each,)) for each in self.deliveries)

    def singles(self) -> list[Iterator[Plan]]:
        """Every fault by itself; what is much alike is together, the simple and early first."""
        found = [self._of(option) for option in self.options]
        found += [self._others_of(option) for option in self.options if self._has_others(option)]
        found += [self._set(*change) for change in self.changes]
        found += [source for option in self.options for source in self._aimed(option)]
        plans = [(Plan((each,)) for each in source) for source in found]
        return [*plans, iter([Plan(arbitration=name) for name in self.arbitrations])]

    def _of(self, option: Option) -> Iterator[Disturbance]:
        """What strikes once comes second as what lasts: only that makes what is known old."""
        moments: Sequence[Disturbance] = self._in_turn(option.node)
        if option.aims:  # of accesses and frames: most of them come in the beginning
            moments = spread(self.moments[option.node])
        plans = self._ranked(option, moments, option.parameters, (1, 3, 4))
        once, *others = option.parameters
        lasting = [each for each in others[:1] if "times" in once and "times" not in each]
        second = [option.at(moments[0], each, None) for each in lasting if moments]
        yield from islice(plans, 1)
        yield from second
        yield from (each for each in plans if each not in second)

    def _others_of(self, option: Option) -> Iterator[Disturbance]:
        """What the default of a device's own fault changes nothing in, another value may."""
        return self._ranked(option, self._in_turn(option.node), option.parameters[1:], (3, 1, 4))

    def _has_others(self, option: Option) -> bool:
        faults = self._nodes[option.node].device.faults
        return option.fault in faults and len(option.parameters) > 1

    def _in_turn(self, node: str) -> Sequence[Disturbance]:
        """First when all is well and settled, as most things do in life, then at its events."""
        moments = spread(self.moments[node])
        settled = [each for each in moments if each.get("at", inf) <= (self._end or 0) / 2]
        last = max(settled, key=lambda each: float(each["at"]), default=None)
        return sorted(moments, key=lambda each: each is not last)

    def _aimed(self, option: Option) -> Iterator[Iterator[Disturbance]]:
        """It comes at its own time: there other aims are worth more than moments."""
        moments = self.moments[option.node]
        for first in range(0, len(option.aims), AIMS):
            aims = option.aims[first : first + AIMS]
            yield self._ranked(option, moments, aims, (AIMS, 1, 2 * AIMS))

    def _ranked(
        self,
        option: Option,
        moments: Sequence[Disturbance],
        given: Sequence[Mapping[str, Any]],
        weights: tuple[int, int, int],
    ) -> Iterator[Disturbance]:
        """Weights say how much a later moment, later parameters and a later length count."""
        choices = product(enumerate(moments), enumerate(given), enumerate(option.lengths))
        for (_, moment), (_, parameters), (_, length) in sorted(
            choices, key=lambda each: sum(w * n for w, (n, _) in zip(weights, each, strict=True))
        ):
            yield option.at(moment, parameters, length)

    # Answers that are just too late

    def learn(self, waits: Iterable[Wait]) -> Iterator[Iterator[Plan]]:
        """What a run has shown: the shortest is tried at every access, others at theirs.

        The next request may be the same again, and its answer as good; what comes before the answer
        to the one after that is of another object, and each of these takes a turn of its own.
        """
        for wait in waits:
            if (new := self._new(wait)) is None:
                continue
            self.events.waits.append(new)
            together = 1 if new.request == NEXT else AIMS
            late = [Plan((each,)) for option in self.options for each in self._late(option, new)]
            for first in range(0, len(late), together):
                yield iter(late[first : first + together])

    def _new(self, wait: Wait) -> Wait | None:
        """It, for as many accesses as it is of use; None if it is known."""
        known = [
            each
            for each in self.events.waits
            if (each.node, each.request) == (wait.node, wait.request)
        ]
        everywhere = [each for each in known if each.address is None]
        if all(wait.seconds < each.seconds for each in everywhere):
            wait = wait._replace(address=None)
        same = [each for each in known if each.is_for(wait.address, wait.access)]
        is_known = any(abs(each.seconds - wait.seconds) <= wait.answer for each in same)
        is_of_use = len(same) < MOST_WAITS and wait.seconds <= self.limits.longest
        return wait if is_of_use and not is_known else None

    def _late(self, option: Option, wait: Wait) -> Iterator[Disturbance]:
        """Aimed at an access from the beginning on, else when all is well and settled."""
        for parameters in self._delayed(option, wait):
            is_aimed = "object" in parameters
            moments = self.moments[option.node] if is_aimed else self._in_turn(option.node)
            yield from (option.at(moment, parameters, None) for moment in moments[:1])

    def delayed(self, option: Option) -> list[Mapping[str, Any]]:
        """What a fault that delays answers can be given besides, as far as anything is learnt."""
        return [each for wait in self.events.waits for each in self._delayed(option, wait)]

    def _delayed(self, option: Option, wait: Wait) -> list[Mapping[str, Any]]:
        if not option.delay or option.node != wait.node:
            return []
        fault = self._nodes[option.node].faults.known[option.fault]
        told = fault.parameters[option.delay]
        if not told.low <= wait.seconds <= told.high:
            return []
        late = {**option.parameters[0], option.delay: wait.seconds}
        whatever = [late] if wait.address is None else []
        return [*whatever, *self._accesses(option.node, fault, late, wait)]

    def _set(self, node: str, key: str, value: object) -> Iterator[Disturbance]:
        for moment in self._in_turn(node):
            yield self.change(moment, node, key, value)

    def change(self, moment: Disturbance, node: str, key: str, value: object) -> Disturbance:
        """A setting that changes while it runs, as a file has it."""
        return {**moment, **({"node": node} if self._several else {}), "set": {key: value}}

    # When

    def _moments(self, node: str) -> Iterator[Disturbance]:
        found: list[tuple[int, float, Disturbance]] = []
        for key, times in self.events.moments.get(node, {}).items():
            condition = self.events.conditions[key]
            if self._is_one_of_many(node, condition):
                continue
            for nth in dict.fromkeys((1, 2, len(times) // 2, len(times))):
                if 1 <= nth <= len(times) and self._is_in_time(times[nth - 1]):
                    when = {**condition, "nth": nth} if nth > 1 else dict(condition)
                    found.append((min(nth, 3), times[nth - 1], {"when": when}))
        found += [(2, time, {"at": time}) for time in MOMENTS if self._is_in_time(time)]
        yield from (moment for *_, moment in sorted(found, key=lambda each: each[:2]))

    def _is_in_time(self, time: float) -> bool:
        return self._end is None or time < self._end

    def _is_one_of_many(self, node: str, condition: Mapping[str, Any]) -> bool:
        """Whether an object is written with so many values that none of them is special."""
        if "write" not in condition:
            return False
        ((name, value),) = condition["write"].items()
        written = [
            self.events.conditions[key]["write"]
            for key in self.events.moments[node]
            if "write" in self.events.conditions[key]
        ]
        return value != "any" and sum(name in each for each in written) > MOST_WORDS + 1

    # What

    def _options(self, node: str) -> Iterator[Option]:
        said = self._scenario.space
        for name, fault in self._nodes[node].faults.known.items():
            weather = WEATHERS.index(fault.weather.least)
            if said.faults is not None:
                wanted = name in said.faults
            else:
                wanted = weather <= WEATHERS.index(said.weather)
            if not wanted or name in said.without:
                continue
            if option := self._option(node, name, fault):
                yield option

    def _option(self, node: str, name: str, fault: Fault) -> Option | None:
        base: dict[str, Any] = {}
        for key, told in fault.parameters.items():
            if told.default is None:
                values = self._values(node, key, told)
                if not values:
                    self.left_out[name] = f"no value to try is known for its {key!r}"
                    return None
                base[key] = values[0]
        counted = "times" in fault.parameters
        variants = [{**base, "times": 1}, base] if counted else [base]  # all, while it lasts
        for key, told in fault.parameters.items():
            for value in self._values(node, key, told):
                variants.append({**variants[0], key: value})
        aims = [*self._frames(node, fault, variants[0]), *self._accesses(node, fault, variants[0])]
        lengths: list[float | None] = [None]
        if fault.clear is not None:
            lengths += [each for each in TIMES if each <= self.limits.longest][::-2]
        taken, aimed = (
            tuple(each for each in _unique(some) if self._is_taken(node, name, each))
            for some in (variants, aims)
        )
        if not taken:
            self.left_out[name] = "the device takes none of the values that are known to be tried"
            return None
        delay = next((key for key, told in fault.parameters.items() if told.delays_answers), "")
        return Option(node, self._several, name, taken, aimed, delay, tuple(lengths))

    def _is_taken(self, node: str, fault: str, parameters: Mapping[str, Any]) -> bool:
        """Whether the device takes it, without power."""
        faults = self._nodes[node].faults
        values = {key: _plain(value) for key, value in parameters.items()}
        try:
            faults.inject(fault, **values)
        except UserError:
            return False
        faults.clear(fault)
        return True

    def _values(self, node: str, key: str, told: Parameter) -> list[Any]:
        """Others than the default that are worth trying."""
        longest = min(told.high, self.limits.longest)
        known: Mapping[str, Sequence[Any]] = {
            "times": range(1, self.limits.losses + 1),
            **dict.fromkeys(OF_TIME, tuple(t for t in TIMES if told.low <= t <= longest)),
            **dict.fromkeys(BY_AIM, ()),
        }
        if told.examples:
            return [_number(key, each) for each in told.examples]
        if key in known:
            return list(known[key])
        if told.kind in (int, float) and isfinite(told.low) and isfinite(told.high):
            middle = (told.low + told.high) / 2
            taken = (told.kind(each) for each in (told.low, told.high, middle))
            return [_number(key, each) for each in dict.fromkeys(taken) if each != told.default]
        return []

    def _frames(self, node: str, fault: Fault, base: Mapping[str, Any]) -> list[dict[str, Any]]:
        if "frame" not in fault.parameters:
            return []
        variants = []
        for frame, times in [*self.events.frames.get(node, {}).items()][:MOST_OBJECTS]:
            variants.append({**base, "frame": frame})
            if len(times) > 1:
                variants.append({**base, "frame": frame, "nth": 2})
        return variants

    def _accesses(
        self, node: str, fault: Fault, base: Mapping[str, Any], wait: Wait | None = None
    ) -> list[dict[str, Any]]:
        """Those of the master, each the first time and the second; with a wait, as it is for."""
        if not {"object", "times"} <= fault.parameters.keys():
            return []
        variants = []
        for access, times in self.events.accesses.items():
            if access.node == node and (wait is None or wait.is_for(access.address, access.access)):
                aimed = {**base, "object": access.object}
                if "access" in fault.parameters:
                    aimed["access"] = access.access
                variants.append(aimed)
                if len(times) > 1:
                    variants.append({**aimed, "nth": 2})
        return variants[: 2 * MOST_OBJECTS]


def _number(key: str, value: Any) -> Any:
    """Codes are written as the manuals have them."""
    if key in HEX and isinstance(value, int) and value > 9:
        return Verbatim(f"{value:#x}")
    return value


def _plain(value: Any) -> Any:
    return int(value, 0) if isinstance(value, Verbatim) else value


def spread(items: Sequence[Item]) -> list[Item]:
    """The first one, the last one, the one between them, those between these, and so on."""
    order = dict.fromkeys((0, len(items) - 1)) if items else {}
    parts = 2
    while len(order) < len(items):
        order |= dict.fromkeys(len(items) * n // parts for n in range(1, parts))
        parts *= 2
    return [items[n] for n in order]


def _unique(variants: Sequence[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    seen = set()
    for each in variants:
        if (key := repr(sorted(each.items()))) not in seen:
            seen.add(key)
            yield each
