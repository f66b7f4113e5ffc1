"""Reads who takes part: a device, its node id, and the settings it is delivered with."""

from collections.abc import Callable, Mapping
from dataclasses import fields as fields_of

from simulators.device import Device
from simulators.documents.document import Item
from simulators.documents.problems import Noted
from simulators.errors import UserError, unknown
from simulators.replay.scenario import NodeSpec

Find = Callable[[str], type[Device]]


def read_node(item: Item, find: Find) -> tuple[str, NodeSpec]:
    """A node and its name, which is that of its device.

    Raises:
        UserError: no such device, or one that cannot be delivered like this.
    """
    fields = item.fields(("device",), ("node_id", "settings"))
    if "device" not in fields:
        raise Noted
    with fields["device"].blamed():
        kind = find(fields["device"].text)
    given = _settings(fields["settings"], kind) if "settings" in fields else {}
    if "node_id" in fields:
        given["node_id"] = fields["node_id"]
    spec = NodeSpec(kind, {name: value.value for name, value in given.items()})
    try:
        spec.create()
    except UserError:
        _blame(kind, given)
        raise
    return fields["device"].text, spec


def _settings(item: Item, kind: type[Device]) -> dict[str, Item]:
    known = {field.name for field in fields_of(kind.settings_type)} - {"node_id"}
    settings = {}
    for name, pair in item.pairs.items():
        with item.problems.at(pair.key):
            if name == "node_id":
                raise pair.key.wrong("the node id stands beside the settings, not among them")
            if name not in known:
                raise unknown("setting", name, known)
            settings[name] = pair.value
    return settings


def _blame(kind: type[Device], given: Mapping[str, Item]) -> None:
    """Raises the refusal of the first setting that is refused even by itself."""
    for name, item in given.items():
        with item.blamed():
            kind(**{name: item.value})
