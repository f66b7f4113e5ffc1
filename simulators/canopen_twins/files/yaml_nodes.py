"""YAML as nodes with their places, and scalars that are what they look like.

Numbers are 16, 0x10 or 0.5, never 010. Only `true` and `false` are truth values: on, off, yes and
no are words. Anchors, aliases and tags are refused.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml
from yaml.composer import Composer, ComposerError
from yaml.reader import ReaderError
from yaml.resolver import Resolver

from canopen_twins.files.problems import DocumentError, Mistake

LARGEST_FILE = 256 * 1024  # bytes

Scalar = int | float | bool | str | None

TAG = "tag:yaml.org,2002:"
READERS: Mapping[str, Callable[[str], Scalar]] = {
    TAG + "int": lambda text: int(text, 0),
    TAG + "float": float,
    TAG + "bool": lambda text: text == "true",
    TAG + "null": lambda _: None,
}
PATTERNS = (
    ("int", r"[-+]?(0|[1-9][0-9]{0,18})|0x[0-9A-Fa-f]{1,16}", "-+0123456789"),
    ("float", r"[-+]?(0|[1-9][0-9]*)(\.[0-9]+)?([eE][-+]?[0-9]+)?", "-+0123456789"),
    ("bool", r"true|false", "tf"),
    ("null", r"null|~|", ["n", "~", ""]),
)
DECEPTIVE = re.compile(r"[-+]?(0[0-9]+|[0-9][0-9_]*_[0-9_]*|0[bo][0-9]+)(\.[0-9]*)?")


FASTEST = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml, where there is one


class Nodes(Composer, Resolver):
    """Composes the nodes of a text, constructs nothing."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012 - as PyYAML has it

    def __init__(self, text: str, parser: Any = FASTEST) -> None:
        super().__init__()
        Resolver.__init__(self)
        self._events: Iterator[yaml.Event] = yaml.parse(text, parser)
        self._next: yaml.Event | None = None

    def peek_event(self) -> Any:
        """The next event of the text."""
        if self._next is None:
            self._next = next(self._events)
        return self._next

    def get_event(self) -> Any:
        """The same, taken away."""
        event, self._next = self.peek_event(), None
        return event

    def check_event(self, *kinds: type[yaml.Event]) -> bool:
        """Whether the next is one of these."""
        return isinstance(self.peek_event(), kinds)

    def compose_node(self, parent: Any, index: Any) -> Any:
        """One node; a value stands where it is used."""
        event = self.peek_event()
        if isinstance(event, yaml.AliasEvent) or event.anchor is not None:
            problem = "there are no anchors and aliases here: write it out"
        elif event.tag is not None:
            problem = f"there are no tags here: leave {event.tag!r} out"
        else:
            return super().compose_node(parent, index)
        raise ComposerError(None, None, problem, event.start_mark)


for kind, pattern, first in PATTERNS:
    Nodes.add_implicit_resolver(TAG + kind, re.compile(f"(?:{pattern})$"), list(first))


def read_text(path: Path) -> str:
    """The text of a file.

    Raises:
        DocumentError: it cannot be read, is too large, or is no text.
    """
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
        text = content.decode("utf-8-sig")
    except OSError as failure:
        raise DocumentError([f"{path}: {failure.strerror}"]) from failure
    except UnicodeDecodeError as failure:
        raise DocumentError([f"{path}: no UTF-8 text"]) from failure
    if len(content) > LARGEST_FILE:
        raise DocumentError([f"{path}: larger than {LARGEST_FILE} bytes"])
    return text


def compose(text: str) -> yaml.Node:
    """The node of a whole file.

    Raises:
        Mistake: it is no YAML, empty, or nested deeper than Python likes.
    """
    try:
        try:
            node: yaml.Node | None = Nodes(text).get_single_node()
        except yaml.YAMLError:  # Python's parser tells better what is wrong, and where
            node = Nodes(text, yaml.SafeLoader).get_single_node()
    except yaml.MarkedYAMLError as failure:
        what = ", ".join(filter(None, (failure.context, failure.problem)))
        raise Mistake(failure.problem_mark or _mark(text, 0), what) from failure
    except ReaderError as failure:
        raise Mistake(_mark(text, failure.position), failure.reason) from failure
    except RecursionError:
        raise Mistake(_mark(text, 0), "nested too deeply; five levels are enough") from None
    if node is None:
        raise Mistake(_mark(text, 0), "an empty file; the first line is version: 1")
    return node


def scalar(node: yaml.ScalarNode) -> Scalar:
    """The value of a node as what it looks like.

    Raises:
        Mistake: a number that would not be the same to everybody.
    """
    if not node.style and DECEPTIVE.fullmatch(node.value):
        raise Mistake(
            node.start_mark,
            f"{node.value} may be taken for different numbers: write 16, 0x10 or 0.5, or a 'text'",
        )
    return READERS.get(node.tag, str)(node.value)


def _mark(text: str, position: int) -> yaml.Mark:
    line_start = text.rfind("\n", 0, position) + 1
    line = text.count("\n", 0, position)
    return yaml.Mark("", position, line, position - line_start, None, 0)
