"""YAML that is ours as nodes, what its scalars mean, and what is wrong with a text that is none.

Numbers are 16, 0x10 or 0.5, never 010. Only `true` and `false` are truth values: on, off, yes and
no are words. Anchors, aliases and tags are refused.
"""

import re
from collections.abc import Callable, Iterator
from typing import Any

import yaml
from yaml.composer import ComposerError
from yaml.reader import ReaderError

from canopen_twins.errors import UserError

SURROGATE = re.compile("[\ud800-\udfff]")
GLUED = re.compile(r"(\w+):(\S.*)")
MISSING_SPACE = "a space is missing after the colon: {}: {}"
"""A key and its value without the space between them."""

Scalar = int | float | bool | str | None


class Mistake(UserError):  # noqa: N818 - of the user's, not of ours
    """Something wrong at a place of the file."""

    def __init__(self, mark: yaml.Mark, text: str) -> None:
        super().__init__(text)
        self.mark = mark


FASTEST = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml, where there is one
DEEPEST = 256  # levels; whoever walks down them recurses


def nodes(text: str, parser: Any = FASTEST) -> yaml.Node | None:
    """The node of a whole text, without tags; None of nothing but comments.

    Raises:
        yaml.YAMLError: it is no YAML of ours.
        RecursionError: it is nested too deeply.
    """
    events = yaml.parse(text, parser)
    next(events)  # the stream starts
    if isinstance(next(events), yaml.StreamEndEvent):
        return None
    node = _node(next(events), events, DEEPEST)
    next(events)  # the document ends
    end: Any = next(events)
    if not isinstance(end, yaml.StreamEndEvent):
        problem = "expected a single document in the stream, but found another document"
        raise ComposerError(None, None, problem, end.start_mark)
    return node


def _node(event: Any, events: Iterator[Any], levels: int) -> yaml.Node:
    mark: Any = event.start_mark
    if isinstance(event, yaml.AliasEvent) or event.anchor is not None:
        problem = "there are no anchors and aliases here: write it out"
        raise ComposerError(None, None, problem, mark)
    if event.tag is not None:
        raise ComposerError(None, None, f"there are no tags here: leave {event.tag!r} out", mark)
    if isinstance(event, yaml.ScalarEvent):
        if SURROGATE.search(event.value):
            raise ComposerError(None, None, f"{event.value!a} has half a character", mark)
        return yaml.ScalarNode("", event.value, mark, style=event.style)
    if not levels:
        raise RecursionError
    inner: list[yaml.Node] = []
    while not isinstance(child := next(events), yaml.CollectionEndEvent):
        inner.append(_node(child, events, levels - 1))
    if isinstance(event, yaml.SequenceStartEvent):
        return yaml.SequenceNode("", inner, mark)
    return yaml.MappingNode("", [*zip(inner[::2], inner[1::2], strict=True)], mark)


def compose(text: str) -> yaml.Node:
    """The node of a whole file.

    Raises:
        Mistake: it is no YAML of ours, empty, or nested too deeply.
    """
    try:
        try:
            node = nodes(text)
        except yaml.YAMLError:  # Python's parser tells better what is wrong, and where
            node = nodes(text, yaml.SafeLoader)
    except yaml.MarkedYAMLError as failure:
        mark = failure.problem_mark or _mark(text, 0)
        if (glued := _glued(text, mark)) is not None:
            raise glued from failure
        what = ", ".join(filter(None, (failure.context, failure.problem)))
        raise Mistake(mark, A_TAB if _is_tab(text, mark) else what) from failure
    except ReaderError as failure:
        raise Mistake(_mark(text, failure.position), failure.reason) from failure
    except RecursionError:
        raise Mistake(_mark(text, 0), "nested too deeply; five levels are enough") from None
    if node is None:
        raise Mistake(_mark(text, 0), "an empty file; the first line is version: 1")
    return node


A_TAB = "a tab: indent with spaces"


def _is_tab(text: str, mark: yaml.Mark) -> bool:
    """Whether a tab stands there or indents the line."""
    line = text.split("\n")[mark.line]
    return "\t" in (line[mark.column : mark.column + 1], *line[: len(line) - len(line.lstrip())])


def _glued(text: str, mark: yaml.Mark) -> Mistake | None:
    """A key without a space after its colon in the line before, where a text seems to go on."""
    line = text.split("\n")[mark.line - 1] if mark.line else ""
    if not (glued := GLUED.fullmatch(line.strip().removeprefix("- ").strip())):
        return None
    place = yaml.Mark("", 0, mark.line - 1, line.index(glued[0]), None, 0)
    return Mistake(place, MISSING_SPACE.format(*glued.groups()))


LOOKS: tuple[tuple[re.Pattern[str], Callable[[str], Scalar]], ...] = (
    (re.compile(r"[-+]?(0|[1-9][0-9]{0,18})|0x[0-9A-Fa-f]{1,16}"), lambda text: int(text, 0)),
    (re.compile(r"[-+]?(0|[1-9][0-9]*)(\.[0-9]+)?([eE][-+]?[0-9]+)?"), float),
    (re.compile(r"true|false"), lambda text: text == "true"),
    (re.compile(r"null|~|"), lambda _: None),
)
"""What a scalar without quotes looks like, and how it is taken; all else is a text."""
DECEPTIVE = re.compile(r"[-+]?(0[0-9]+|[0-9][0-9_]*_[0-9_]*|0[bo][0-9]+)(\.[0-9]*)?")


def scalar(node: yaml.ScalarNode) -> Scalar:
    """The value of a node as what it looks like.

    Raises:
        Mistake: a number that would not be the same to everybody.
    """
    text: str = node.value
    if node.style:
        return text
    if DECEPTIVE.fullmatch(text):
        raise Mistake(
            node.start_mark,
            f"{text} may be taken for different numbers: write 16, 0x10 or 0.5, or a 'text'",
        )
    return next((take(text) for look, take in LOOKS if look.fullmatch(text)), text)


def _mark(text: str, position: int) -> yaml.Mark:
    *_, line = text[:position].rpartition("\n")
    return yaml.Mark("", position, text.count("\n", 0, position), len(line), None, 0)
