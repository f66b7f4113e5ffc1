"""YAML as people write it: of the nodes of a file, and of plain values.

Numbers and texts stay as they stand in the file; comments are lost.
"""

import json
import re
from collections.abc import Mapping, Sequence

import yaml

from canopen_twins.files.yaml_nodes import DECEPTIVE, LOOKS

WIDTH = 100
PLAIN = re.compile(r"[A-Za-z0-9_./+-](([A-Za-z0-9_./+ ()-]|:(?=\S))*[A-Za-z0-9_./+()-])?")
WORDS = re.compile(r"yes|no|on|off|y|n", re.IGNORECASE)  # truth values to other readers


class Verbatim(str):
    """A number as it is to stand in the file, such as 0x2300."""

    __slots__ = ()


def node_of(value: object) -> yaml.Node:
    """A node of mappings, sequences, texts, numbers and truth values; of a node, itself."""
    if isinstance(value, yaml.Node):
        return value
    if isinstance(value, Mapping):
        return yaml.MappingNode("", [(node_of(key), node_of(each)) for key, each in value.items()])
    if isinstance(value, (list, tuple)):
        return yaml.SequenceNode("", [node_of(each) for each in value])
    if isinstance(value, str) and not isinstance(value, Verbatim):
        return yaml.ScalarNode("", value, style=None if _is_plain(value) else '"')
    if isinstance(value, bool) or value is None:
        return yaml.ScalarNode("", json.dumps(value))
    return yaml.ScalarNode("", f"{value:.12g}" if isinstance(value, float) else str(value))


def _is_plain(text: str) -> bool:
    looks_like_another = any(look.fullmatch(text) for look, _ in LOOKS)
    return bool(PLAIN.fullmatch(text)) and not looks_like_another and not DECEPTIVE.fullmatch(text)


def write_yaml(node: yaml.Node) -> str:
    """The text of a whole file."""
    return "\n".join(_block(node, 0)) + "\n"


def _block(node: yaml.Node, indent: int) -> list[str]:
    if isinstance(node, yaml.MappingNode):
        return [line for key, value in node.value for line in _pair(key, value, indent)]
    assert isinstance(node, yaml.SequenceNode)
    lines = []
    for item in node.value:
        first, *others = _fit(item, indent + 2)
        lines += [f"{' ' * indent}- {first.lstrip()}", *others]
    return lines


def _pair(key: yaml.Node, value: yaml.Node, indent: int) -> Sequence[str]:
    head = f"{' ' * indent}{_flow(key)}:"
    many = isinstance(value, yaml.SequenceNode) and any(
        isinstance(each, yaml.MappingNode) for each in value.value
    )
    if not many:
        lines = _fit(value, indent + 2)
        if len(lines) == 1 and len(head) + len(lines[0]) - indent < WIDTH:
            return [f"{head} {lines[0].lstrip()}"]
        return [head, *lines]
    return [head, *_block(value, indent + 2)]


def _fit(node: yaml.Node, indent: int) -> list[str]:
    """In one line, if there is room."""
    flow = " " * indent + _flow(node)
    if isinstance(node, yaml.ScalarNode) or (len(flow) <= WIDTH and not _has_note(node)):
        return [flow]
    return _block(node, indent)


def _has_note(node: yaml.Node) -> bool:
    return isinstance(node, yaml.MappingNode) and any(key.value == "note" for key, _ in node.value)


def _flow(node: yaml.Node) -> str:
    if isinstance(node, yaml.MappingNode):
        pairs = (f"{_flow(key)}: {_flow(value)}" for key, value in node.value)
        return f"{{{', '.join(pairs)}}}"
    if isinstance(node, yaml.SequenceNode):
        return f"[{', '.join(map(_flow, node.value))}]"
    assert isinstance(node, yaml.ScalarNode)
    plain = not node.style and (PLAIN.fullmatch(node.value) or node.value == "")
    return str(node.value) if plain else json.dumps(node.value, ensure_ascii=False)
