"""The first difference of two runs in words."""

from collections.abc import Iterable, Iterator

from simulators.clock import MICROSECONDS
from simulators.record.compare import Difference, compare
from simulators.record.events import EventLine
from simulators.record.frames import TimedFrame
from simulators.record.inputs import other_inputs
from simulators.record.side import Side

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
