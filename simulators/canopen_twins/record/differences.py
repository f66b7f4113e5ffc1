"""Where two runs begin to differ, in words: read side by side, with little of them in memory."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, islice
from operator import eq
from pathlib import Path
from typing import Generic, NamedTuple, TypeVar

from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.identifiers import Cob, classify
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node, wait_for_boot
from canopen_twins.diagnosis.decoder import Decoder
from canopen_twins.errors import UserError
from canopen_twins.faults import connect
from canopen_twins.record.folder import Recorded
from canopen_twins.record.journal import HEARD, EventLine
from canopen_twins.record.manifest import Manifest
from canopen_twins.record.trace import TimedFrame
from canopen_twins.record.trace_reader import read_frames

BEFORE, AHEAD = 5, 50  # kept before the difference, and read on behind it
LAST_EVENTS = 5  # told of each side
LONGEST = 120  # characters of a value
WIDTH = 8  # of the name of a side

Item = TypeVar("Item")


@dataclass(frozen=True)
class Side:
    """One of two runs, called `name` in what is told."""

    name: str
    recorded: Recorded | None
    frames: Iterable[TimedFrame]

    @classmethod
    def of(
        cls,
        name: str,
        path: Path,
        open_trace: Callable[[Path], Iterable[TimedFrame]] = read_frames,
    ) -> Side:
        """A record, if it is a directory; of others `open_trace` gives the frames.

        Raises:
            UserError: it is neither a record nor a file.
        """
        if path.is_dir():
            recorded = Recorded(path)
            return cls(name, recorded, read_frames(recorded.trace))
        return cls(name, None, open_trace(path))

    def tell(self, sent: TimedFrame) -> str:
        """A frame with its time, in words as far as the devices are known."""
        words = self._decoder.words(sent.frame)
        return f"{sent.tick / MICROSECONDS:12.6f}  {sent.frame!s:21}  {words}".rstrip()

    def last_events(self, tick: int | None) -> Iterable[EventLine]:
        """Those up to a moment, or to the end; what came from outside is no news."""
        last: deque[EventLine] = deque(maxlen=LAST_EVENTS)
        for event in self.recorded.events if self.recorded else ():
            if tick is not None and event.time * MICROSECONDS > tick:
                break
            if event.kind != HEARD:
                last.append(event)
        return last

    @cached_property
    def _decoder(self) -> Decoder:
        """With the dictionaries that the devices of a record have after a boot."""
        segment: Segment[Node] = Segment()
        if self.recorded is None:
            return Decoder([])
        try:
            for node in self.recorded.manifest.nodes:
                connect(segment, node.create(self.recorded.folder), node.name)
        except UserError:  # a record of devices that are here no more still has its frames
            return Decoder([])
        for connected in segment.nodes:
            connected.power_on()
        wait_for_boot(segment.nodes, segment.advance)
        return Decoder(segment.nodes)


SLAVES, MASTERS = "slaves", "masters"
OF_SLAVES = (Cob.EMCY, Cob.TPDO, Cob.SDO_ANSWER, Cob.HEARTBEAT, Cob.LSS_ANSWER)
CLOCKS_APART = MICROSECONDS  # microseconds; two traces begin at times of their own


@dataclass(frozen=True)
class Likeness:
    """What is compared of two runs, and what is as good as the same."""

    time: int = 0
    """Microseconds."""
    only: str = ""
    """`SLAVES` or `MASTERS`, by the predefined connection set; empty for both directions."""

    def wanted(self, sent: TimedFrame) -> bool:
        """Whether a frame is compared."""
        if not self.only:
            return True
        known = None if sent.frame.extended else classify(sent.frame.can_id)
        of_slave = known is not None and known.cob in OF_SLAVES and not sent.frame.remote
        return of_slave is (self.only == SLAVES)

    def same(self, one: TimedFrame, other: TimedFrame) -> bool:
        """Whether two frames are as good as the same."""
        return one.frame == other.frame and abs(one.tick - other.tick) <= self.time


EXACT = Likeness()


def differences(left: Side, right: Side, likeness: Likeness = EXACT) -> tuple[bool, str]:
    """Whether two runs are the same, and what there is to say about it.

    Traces of two clocks are compared from the first frame on that both have.

    Raises:
        UserError: one of them cannot be read to its end.
    """
    wanted = (filter(likeness.wanted, side.frames) for side in (left, right))
    later, ours, theirs = _one_clock(*wanted)
    frames = compare(ours, theirs, likeness.same)
    apart = f"{right.name} has a clock {later / MICROSECONDS:.6f} s ahead, which is left out\n"
    told_apart = apart if later else ""
    if frames:
        return False, told_apart + "\n".join(_frames(frames, left, right))
    told = f"{told_apart}the same {_count(frames.common, 'frame')}"
    if left.recorded is None or right.recorded is None:
        return True, told
    events = compare(left.recorded.events, right.recorded.events)
    if events:
        told = f"{told}, but event {events.common + 1} is another one:"
        lines = [*_events(events, left, right), *_inputs(left, right)]
        return False, "\n".join([told, *lines])
    told = f"{told} and {_count(events.common, 'event')}"
    return True, "\n".join([told, *_inputs(left, right)])


def _one_clock(
    left: Iterator[TimedFrame], right: Iterator[TimedFrame]
) -> tuple[int, Iterator[TimedFrame], Iterator[TimedFrame]]:
    """How far the clock of the right is ahead, and both as that of the left has it."""
    heads = [list(islice(side, AHEAD)) for side in (left, right)]
    ticks: dict[Frame, int] = {}
    for sent in heads[1]:
        ticks.setdefault(sent.frame, sent.tick)
    common = (ticks[sent.frame] - sent.tick for sent in heads[0] if sent.frame in ticks)
    later = next(common, 0)
    whole = chain(heads[0], left), chain(heads[1], right)
    if abs(later) <= CLOCKS_APART:
        return 0, *whole
    return later, whole[0], (sent._replace(tick=sent.tick - later) for sent in whole[1])


class Difference(NamedTuple, Generic[Item]):
    """The first difference of two sequences, and what is around it."""

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


def compare(
    left: Iterable[Item], right: Iterable[Item], same: Callable[[Item, Item], bool] = eq
) -> Difference[Item]:
    """Read both as far as they are the same."""
    ours, theirs = iter(left), iter(right)
    before: deque[Item] = deque(maxlen=BEFORE)
    common = 0
    while True:
        one, other = tuple(islice(ours, 1)), tuple(islice(theirs, 1))
        if not (one and other and same(one[0], other[0])):
            break
        before.extend(one)
        common += 1
    ahead = (*one, *islice(ours, AHEAD)), (*other, *islice(theirs, AHEAD))
    return Difference(common, tuple(before), *ahead)


def _frames(found: Difference[TimedFrame], left: Side, right: Side) -> Iterator[str]:
    are = "is" if found.common == 1 else "are"
    same = f"the first {_count(found.common, 'frame')} {are} the same:"
    yield same if found.common else "not even the first frame is the same:"
    for sent in found.before:
        yield _line("", left.tell(sent))
    sides = (left, found.left), (right, found.right)
    for side, sents in sides:
        yield _line(side.name, side.tell(sents[0]) if sents else "     no more frames")
    yield _change(found, left.name, right.name)
    yield from _inputs(left, right)
    for side, sents in sides:
        events = side.last_events(sents[0].tick if sents else None)
        yield from _block(f"what happened in {side.name}:", map(str, events))


def _change(found: Difference[TimedFrame], left: str, right: str) -> str:
    """Whether frames are missing, or more, or which one is another there."""
    ours, theirs = found.left, found.right
    if not ours or not theirs:
        ended, going = (left, right) if theirs else (right, left)
        return f"{ended} ends here, {going} goes on"
    for more, rest, who in ((ours, theirs, left), (theirs, ours, right)):
        if rest[0] in more:
            count = more.index(rest[0])
            return f"{who} has {_count(count, 'frame')} more, then the other goes on like it"
    return _other_frame(ours[0], theirs[0], left, right)


def _other_frame(one: TimedFrame, other: TimedFrame, left: str, right: str) -> str:
    """Of two frames, neither of which comes on the other side."""
    late = abs(one.tick - other.tick) / MICROSECONDS
    later = f", {late:.6f} s later in {right if other.tick > one.tick else left}" if late else ""
    if one.frame == other.frame:
        return f"the same frame{later}"
    if one.frame.can_id != other.frame.can_id or len(one.frame.data) != len(other.frame.data):
        return f"another frame{later}"
    others = [
        f"byte {place} is {a:02X} in {left}, {b:02X} in {right}"
        for place, (a, b) in enumerate(zip(one.frame.data, other.frame.data, strict=True))
        if a != b
    ]
    what = f"other data{later}: {', '.join(others)}"
    return what if others else f"a frame of another kind{later}"


def _events(found: Difference[EventLine], left: Side, right: Side) -> Iterator[str]:
    for event in found.before:
        yield _line("", str(event))
    for side, events in ((left, found.left), (right, found.right)):
        yield _line(side.name, str(events[0]) if events else "     no more events")


def _inputs(left: Side, right: Side) -> Iterator[str]:
    """What two records were made of: versions, seed, devices, settings, the scenario."""
    if left.recorded is None or right.recorded is None:
        return
    ours, theirs = _leaves(left.recorded.manifest), _leaves(right.recorded.manifest)
    pairs = {name: (ours.get(name, "none"), theirs.get(name, "none")) for name in ours | theirs}
    lines = [
        f"{name}: {_short(one)} in {left.name}, {_short(other)} in {right.name}"
        for name, (one, other) in sorted(pairs.items())
        if one != other
    ]
    lines += _other_line(left.recorded, right.recorded)
    yield from _block("what is not the same from the beginning:", lines)


def _leaves(manifest: Manifest) -> dict[str, str]:
    """What it says, each value by a name of its own."""
    leaves: dict[str, object] = manifest.model_dump(include={"kind", "scenario", "seed"})
    leaves |= {f"version of {name}": number for name, number in manifest.versions.items()}
    leaves |= {f"content of {name}": digest for name, digest in manifest.files.items()}
    for node in manifest.nodes:
        leaves[f"device of {node.name}"] = node.device
        leaves[f"memory of {node.name}"] = node.memory
        leaves |= {f"{key} of {node.name}": value for key, value in node.settings.items()}
    return {name: "none" if value is None else str(value) for name, value in leaves.items()}


def _other_line(left: Recorded, right: Recorded) -> Iterator[str]:
    """The first line of the scenarios that is another one."""
    if left.manifest.scenario is None or right.manifest.scenario is None:
        return
    ours, theirs = (side.scenario.read_bytes().splitlines() for side in (left, right))
    found = compare(ours, theirs)
    if found:
        place = f"line {found.common + 1} of the scenario"
        yield f"{place}: {_first(found.left)} / {_first(found.right)}"


def _first(lines: tuple[bytes, ...]) -> str:
    return repr(_short(lines[0].decode("utf-8", "replace"))) if lines else "none"


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


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
