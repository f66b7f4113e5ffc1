"""Where two sequences begin to differ: read side by side, with little of them in memory."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Generic, NamedTuple, TypeVar

from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.decoder import Decoder
from canopen_twins.errors import UserError
from canopen_twins.faults import connect
from canopen_twins.record.about import About
from canopen_twins.record.events import HEARD, EventLine
from canopen_twins.record.recorded import Recorded
from canopen_twins.record.trace import TimedFrame, read_frames

BEFORE, AHEAD = 5, 50  # kept before the difference, and read on behind it

Item = TypeVar("Item")


class Difference(NamedTuple, Generic[Item]):
    """The first difference, and what is around it."""

    common: int
    """How many are the same on both sides."""
    before: tuple[Item, ...]
    """The last of these."""
    left: tuple[Item, ...]
    """What comes next on the one side; nothing if it has ended."""
    right: tuple[Item, ...]
    """The same for the other."""

    def __bool__(self) -> bool:
        """Whether there is one."""
        return bool(self.left or self.right)


def compare(left: Iterable[Item], right: Iterable[Item]) -> Difference[Item]:
    """Read both as far as they are the same."""
    ours, theirs = iter(left), iter(right)
    before: deque[Item] = deque(maxlen=BEFORE)
    common = 0
    for one, other in _pairs(ours, theirs):
        if one != other:
            return Difference(common, tuple(before), _ahead(one, ours), _ahead(other, theirs))
        before.extend(one)
        common += 1
    return Difference(common, tuple(before), (), ())


def _pairs(
    left: Iterator[Item], right: Iterator[Item]
) -> Iterator[tuple[tuple[Item, ...], tuple[Item, ...]]]:
    """One of each, in tuples that are empty where a side has ended."""
    while True:
        pair = tuple(islice(left, 1)), tuple(islice(right, 1))
        if not any(pair):
            return
        yield pair


def _ahead(first: tuple[Item, ...], rest: Iterator[Item]) -> tuple[Item, ...]:
    return (*first, *islice(rest, AHEAD))


LONGEST = 120  # characters of a value


def other_inputs(left: Side, right: Side) -> Iterator[str]:
    """A line for each: versions, seed, devices, settings, the scenario."""
    if left.recorded is None or right.recorded is None:
        return
    ours, theirs = _flat(left.recorded.about), _flat(right.recorded.about)
    for name in sorted(ours.keys() | theirs.keys()):
        one, other = ours.get(name, "none"), theirs.get(name, "none")
        if one != other:
            yield f"{name}: {_short(one)} in {left.name}, {_short(other)} in {right.name}"
    yield from _scenarios(left.recorded, right.recorded)


def _flat(about: About) -> Mapping[str, str]:
    """The content of a run.json by the names of its leaves."""
    content = about.model_dump(include={"kind", "scenario", "seed"})
    flat = {name: _word(value) for name, value in content.items()}
    flat |= {f"version of {name}": number for name, number in about.versions.items()}
    flat |= {f"content of {name}": digest for name, digest in about.files.items()}
    for node in about.nodes:
        flat[f"device of {node.name}"] = node.device
        flat[f"memory of {node.name}"] = _word(node.memory)
        flat |= {f"{key} of {node.name}": _word(each) for key, each in node.settings.items()}
    return flat


def _word(value: object) -> str:
    return "none" if value is None else str(value)


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


def _scenarios(left: Recorded, right: Recorded) -> Iterator[str]:
    """The first line of the files that is another one."""
    if left.about.scenario is None or right.about.scenario is None:
        return
    lines = [side.scenario.read_bytes().splitlines() for side in (left, right)]
    if found := compare(*lines):
        place = f"line {found.common + 1} of the scenario"
        yield f"{place}: {_one_line(found.left)} / {_one_line(found.right)}"


def _one_line(lines: tuple[bytes, ...]) -> str:
    return repr(_short(lines[0].decode("utf-8", "replace"))) if lines else "none"


LONGEST_BOOT, GRAIN = 5.0, 0.1  # seconds
TOLD = 5  # events


@dataclass(frozen=True)
class Side:
    """Called `name` in what is told."""

    name: str
    recorded: Recorded | None
    trace: Path

    @classmethod
    def of(cls, name: str, path: Path) -> Side:
        """A record, if it is a directory.

        Raises:
            UserError: it is neither a record nor a file.
        """
        if path.is_dir():
            recorded = Recorded(path)
            return cls(name, recorded, recorded.trace)
        return cls(name, None, path)

    @property
    def frames(self) -> Iterator[TimedFrame]:
        """Raises `UserError` where they cannot be read."""
        return read_frames(self.trace)

    def tell(self, sent: TimedFrame) -> str:
        """A frame with its time, in words as far as the devices are known."""
        words = self._decoder.words(sent.frame)
        return f"{sent.tick / MICROSECONDS:12.6f}  {sent.frame!s:21}  {words}".rstrip()

    def happened(self, tick: int | None) -> tuple[EventLine, ...]:
        """The last events up to a moment, or to the end; what came from outside is no news."""
        last: deque[EventLine] = deque(maxlen=TOLD)
        for event in self.recorded.events if self.recorded else ():
            if tick is not None and event.time * MICROSECONDS > tick:
                break
            if event.kind != HEARD:
                last.append(event)
        return tuple(last)

    @cached_property
    def _decoder(self) -> Decoder:
        """With the dictionaries that the devices of a record have after a boot."""
        segment: Segment[Node] = Segment()
        try:
            for part in self.recorded.about.nodes if self.recorded else ():
                connect(segment, part.create(), part.name)
        except UserError:  # a record of devices that are here no more still has its frames
            return Decoder([])
        for node in segment.nodes:
            node.power_on()
        while segment.clock.now < LONGEST_BOOT and any(
            node.slave is None for node in segment.nodes
        ):
            segment.advance(GRAIN)
        return Decoder(segment.nodes)


WIDTH = 8  # of the name of a side


def differences(left: Side, right: Side) -> tuple[bool, str]:
    """Whether two runs are the same, and what there is to say about it.

    Raises:
        UserError: one of them cannot be read to its end.
    """
    frames = compare(left.frames, right.frames)
    if frames:
        return False, "\n".join(_frames(frames, left, right))
    told = f"the same {_count(frames.common, 'frame')}"
    if left.recorded is None or right.recorded is None:
        return True, told
    events = compare(left.recorded.events, right.recorded.events)
    if events:
        lines = [f"{told}, but event {events.common + 1} is another one:"]
        lines += [*_events(events, left, right), *_others(left, right)]
        return False, "\n".join(lines)
    told = f"{told} and {_count(events.common, 'event')}"
    return True, "\n".join([told, *_others(left, right)])


def _frames(found: Difference[TimedFrame], left: Side, right: Side) -> Iterator[str]:
    yield _same(found.common)
    for sent in found.before:
        yield _line("", left.tell(sent))
    for side, sents in ((left, found.left), (right, found.right)):
        yield _line(side.name, side.tell(sents[0]) if sents else "     no more frames")
    yield _what(found, left.name, right.name)
    yield from _others(left, right)
    for side, sents in ((left, found.left), (right, found.right)):
        events = side.happened(sents[0].tick if sents else None)
        yield from _block(f"what happened in {side.name}:", map(str, events))


def _same(common: int) -> str:
    if not common:
        return "not even the first frame is the same:"
    return f"the first {_count(common, 'frame')} {'is' if common == 1 else 'are'} the same:"


def _what(found: Difference[TimedFrame], left: str, right: str) -> str:
    """What is another one there."""
    ours, theirs = found.left, found.right
    if not ours or not theirs:
        ended, going = (left, right) if theirs else (right, left)
        return f"{ended} ends here, {going} goes on"
    for more, rest, who in ((ours, theirs, left), (theirs, ours, right)):
        if rest[0] in more:
            count = more.index(rest[0])
            return f"{who} has {_count(count, 'frame')} more, then the other goes on like it"
    return _change(ours[0], theirs[0], left, right)


def _change(one: TimedFrame, other: TimedFrame, left: str, right: str) -> str:
    """Of two frames, neither of which comes on the other side."""
    late = abs(one.tick - other.tick) / MICROSECONDS
    later = f", {late:.6f} s later in {right if other.tick > one.tick else left}" if late else ""
    if one.frame == other.frame:
        return f"the same frame{later}"
    if one.frame.can_id != other.frame.can_id or len(one.frame.data) != len(other.frame.data):
        return f"another frame{later}"
    pairs = enumerate(zip(one.frame.data, other.frame.data, strict=True))
    others = [
        f"byte {place} is {a:02X} in {left}, {b:02X} in {right}"
        for place, (a, b) in pairs
        if a != b
    ]
    return (
        f"other data{later}: {', '.join(others)}" if others else f"a frame of another kind{later}"
    )


def _events(found: Difference[EventLine], left: Side, right: Side) -> Iterator[str]:
    for event in found.before:
        yield _line("", str(event))
    for side, events in ((left, found.left), (right, found.right)):
        yield _line(side.name, str(events[0]) if events else "     no more events")


def _others(left: Side, right: Side) -> Iterator[str]:
    return _block("what is not the same from the beginning:", other_inputs(left, right))


def _block(title: str, lines: Iterable[str]) -> Iterator[str]:
    """Nothing at all if there is no line."""
    for number, line in enumerate(lines):
        if not number:
            yield title
        yield _line("", line)


def _line(name: str, text: str) -> str:
    return f"{name:{WIDTH}}{text}"


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
