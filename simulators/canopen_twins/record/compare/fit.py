"""The settings of a twin with which it is most like the device of a trace."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import islice, pairwise
from statistics import median, quantiles
from typing import Any, Literal, get_args, get_origin, get_type_hints

from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.device.settings import NodeSettings
from canopen_twins.errors import UserError
from canopen_twins.record.compare.agreement import Agreement
from canopen_twins.record.compare.comparison import Comparison
from canopen_twins.record.compare.shown import Shown
from canopen_twins.record.compare.tolerances import Tolerances
from canopen_twins.record.trace import TimedFrame
from canopen_twins.scenario.scenario import NodeSpec

TRIED_WITH = 20_000  # frames; every trial plays them anew
ROUNDS = 3  # a setting may show only after another has been found
REFRESHES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0)  # seconds, as devices have them
MOST_STEPS, MOST_TRIED = 1000, 3  # of a series
FEW = 4  # values say nothing of noise
MOST_NOISE = 0.02  # of the highest value: what is further apart is another value
DIGITS = 4  # of a time in seconds
UNDECIDED = frozenset(field.name for field in fields(NodeSettings))
"""Settings that are worked out of times, or that no trace decides."""

Specs = Mapping[str, NodeSpec]


@dataclass(frozen=True)
class Trial:
    """How well nodes with some settings agree with a trace."""

    specs: Specs
    agreement: Agreement
    shown: Mapping[str, Shown]

    @property
    def score(self) -> tuple[float, int]:
        """The more the better: what agrees, then how few kinds of differences there are."""
        return self.agreement.share, -len(self.agreement.differences)


class Fit:
    """A greedy search: one setting after the other is changed, and kept if the twin gains by it."""

    def __init__(self, specs: Specs, frames: Iterable[TimedFrame], tolerances: Tolerances) -> None:
        """Raises `UserError` as a comparison does."""
        self._frames: Sequence[TimedFrame] = list(islice(frames, TRIED_WITH))
        self._tolerances = tolerances
        self._tried: set[str] = set()
        self.best = self._try(specs)
        for name in specs:
            self._fit(name)

    def _fit(self, name: str) -> None:
        for settings in _times(self.best.shown[name]):
            self._offer(name, settings, is_better=False)
        for _ in range(ROUNDS):
            before = self.best
            for settings in (*_values(self.best, name), *_choices(self.best.specs[name])):
                self._offer(name, settings)
            if self.best is before:
                break
        for settings in _measurement(self.best.shown[name]):
            self._offer(name, settings)

    def _offer(self, name: str, settings: Mapping[str, object], is_better: bool = True) -> None:
        """Take settings over if they make the twin more like the device, or no less like it."""
        if is_better and self.best.score == (1.0, 0):
            return
        spec = self.best.specs[name]
        known = {field.name for field in fields(spec.device.settings)}
        if not settings.keys() <= known:
            return
        changed = NodeSpec(spec.device, {**spec.settings, **settings})
        specs = {**self.best.specs, name: changed}
        if (tried := _all_settings(specs)) in self._tried:
            return  # it has come to what it comes to
        self._tried.add(tried)
        try:
            trial = self._try(specs)
        except UserError:
            return  # they do not go together
        if trial.score > self.best.score or (not is_better and trial.score == self.best.score):
            self.best = trial

    def _try(self, specs: Specs) -> Trial:
        devices = {name: spec.create() for name, spec in specs.items()}
        comparison = Comparison(devices, self._tolerances)
        shown = {name: beside.show() for name, beside in comparison.nodes.items()}
        for sent in self._frames:
            comparison.hear(sent.tick, sent.frame)
        return Trial(specs, comparison.end(), shown)


def _all_settings(specs: Specs) -> str:
    return repr({name: sorted(spec.settings.items()) for name, spec in specs.items()})


def _times(shown: Shown) -> Iterator[Mapping[str, object]]:
    """Booting, answering and storing, each by what is in the middle, and its spread."""
    if shown.boot_times:
        yield {"boot_time": _seconds(median(shown.boot_times))}
    if len(shown.answer_times) > 1:
        cuts = quantiles(shown.answer_times, n=100, method="inclusive")
        yield {"answer_time": _seconds(cuts[0]), "answer_jitter": _seconds(cuts[-1] - cuts[0])}
    if shown.store_times:
        usual = median(shown.answer_times) if shown.answer_times else 0.0
        yield {"store_time": _seconds(max(median(shown.store_times) - usual, 0.0))}


def _values(trial: Trial, name: str) -> Iterator[Mapping[str, object]]:
    """Settings that have the value that the twin has answered, where the device has another."""
    spec, shown = trial.specs[name], trial.shown[name]
    settings = spec.create().settings
    pairs = [(theirs, ours) for theirs, ours in shown.read.values() if theirs != ours]
    if shown.beats and (0x1017, 0) not in shown.read:
        beat = round(median(shown.beats) / 1000)
        pairs += [
            (beat, getattr(settings, field.name))
            for field in fields(settings)
            if field.name.startswith("heartbeat") and field.name.endswith("_ms")
        ]
    for theirs, ours in pairs:
        for field in fields(settings):
            value = getattr(settings, field.name)
            if field.name not in UNDECIDED and type(value) is type(ours) and value == ours:
                yield {field.name: theirs}


def _choices(spec: NodeSpec) -> Iterator[Mapping[str, object]]:
    """Every other word of a setting that has some, and every other truth."""
    settings: Any = spec.create().settings
    hints = get_type_hints(type(settings))
    for field in fields(settings):
        if field.name in UNDECIDED and field.name != "store_busy":
            continue
        kind, now = hints[field.name], getattr(settings, field.name)
        words = get_args(kind) if get_origin(kind) is Literal else (True, False)
        if get_origin(kind) is Literal or kind is bool:
            yield from ({field.name: word} for word in words if word != now)


def _measurement(shown: Shown) -> Iterator[Mapping[str, object]]:
    """The time for which a value stays as it is, then the noise around what the twin has."""
    steps = {
        _seconds(later.tick - earlier.tick)
        for samples in shown.series.values()
        for earlier, later in pairwise(samples[:MOST_STEPS])
    }
    for time in sorted({*REFRESHES, *sorted(steps)[:MOST_TRIED]}):
        yield {"measure_time": time}
    noises = [noise for pairs in shown.measured.values() if (noise := _noise(pairs))]
    if noises:
        yield {"noise": float(max(noises))}


def _noise(pairs: Sequence[tuple[float, float]]) -> float:
    """What nearly all values are off by at most; none if that is more than noise can be."""
    if len(pairs) < FEW:
        return 0.0
    apart = quantiles([abs(one - other) for one, other in pairs], n=100, method="inclusive")[-1]
    return apart if apart <= MOST_NOISE * max(abs(one) for one, _ in pairs) else 0.0


def _seconds(microseconds: float) -> float:
    return round(microseconds / MICROSECONDS, DIGITS)
