"""What a node is at a moment, as the control port says it; only for the thread of the twins."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields
from math import isfinite
from typing import Any, TypeVar

from canopen_twins.device import chart, faults
from canopen_twins.device.node import Node
from canopen_twins.device.settings import declaration
from canopen_twins.diagnosis.sections import sections
from canopen_twins.diagnosis.why import why
from canopen_twins.live.bus import steady
from canopen_twins.live.control.schema import (
    ActiveFault,
    BandNow,
    CurveNow,
    Emergency,
    Fault,
    NodeName,
    NodeState,
    ObjectEntry,
    Setting,
)
from canopen_twins.live.orders import Portions
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.emcy import Emcy
from canopen_twins.slave.object import TYPES

LONGEST_PORTION = 0.0003  # seconds

Item = TypeVar("Item")


def node_name(node: Node) -> NodeName:
    """Who it is, and whether it is there."""
    name, state = node.wire.name, str(node.state)
    return NodeName(name, node.device.title, node.node_id, state, node.powered)


def node_state(node: Node) -> NodeState:
    """Everything that is quickly told."""
    device = node.look()
    return NodeState(
        **vars(node_name(node)),
        moment=node.clock.ticks,
        booting=node.booting,
        silence=" ".join(why(node, ())),
        report=plain(device.report),
        faults=active_faults(node),
        errors=[emergency(each) for each in device.emergencies],
        history=[emergency(each) for each in node.log.history],
        curves=[_curve(each) for each in device.chart.curves],
        band=_band(device.chart),
    )


def active_faults(node: Node) -> list[ActiveFault]:
    """In the order in which they came."""
    active = node.faults.active.items()
    return [
        ActiveFault(name, plain(given), node.faults.words(name, given)) for name, given in active
    ]


def node_settings(node: Node) -> list[Setting]:
    """All settings; any thread may ask."""
    now, delivered = node.device.settings, type(node.device).settings
    return [
        Setting(
            name=each.name,
            value=plain(getattr(now, each.name)),
            default=plain(getattr(delivered, each.name)),
            **_typed(declaration(each, type(now))),
        )
        for each in fields(now)
    ]


def known_faults(known: Mapping[str, faults.Fault]) -> dict[str, Fault]:
    """What can be injected; any thread may ask."""
    return {name: Fault(**_typed(fault.declaration)) for name, fault in known.items()}


def objects(node: Node) -> Iterator[ObjectEntry]:
    """The dictionary in force; none while the node is silent."""
    sources = sections(node.device.eds)
    for entries in () if node.slave is None else node.slave.entries.values():
        for entry in entries.values():
            variable = entry.variable
            yield ObjectEntry(
                address=address_text(entry.address),
                name=variable.qualname,
                type=TYPES.get(variable.data_type or 0, "?"),
                access=variable.access_type,
                low=entry.low,
                high=entry.high,
                section=sources.object(entry.address),
            )


def in_portions(items: Iterable[Item]) -> Portions[list[Item]]:
    """A list of what takes long to be had, cut where a frame may be answered."""
    taken: list[Item] = []
    begun = steady()
    for item in items:
        taken.append(item)
        if steady() - begun > LONGEST_PORTION:
            yield
            begun = steady()
    return taken


def _typed(told: Mapping[str, object]) -> dict[str, Any]:
    return dict(told)


def _curve(curve: chart.Curve) -> CurveNow:
    wanted = None if curve.wanted is None else curve.wanted()
    return CurveNow(curve.label, curve.unit, plain(curve.actual()), plain(wanted))


def _band(told: chart.Chart) -> BandNow | None:
    if told.band is None:
        return None
    label, mood = told.band()
    return BandNow(label, mood.name)


def emergency(emcy: Emcy) -> Emergency:
    """An error in the words of the port."""
    return Emergency(emcy.code, emcy.register, emcy.detail, emcy.label)


def plain(value: Any) -> Any:
    """A value as JSON has it; bytes are told in hex, an infinite number and what else there is by
    its text."""
    if isinstance(value, bool | int | str) or value is None:
        return value if type(value) in (bool, int, str, type(None)) else str(value)
    if isinstance(value, float):
        return value if isfinite(value) else str(value)
    if isinstance(value, bytes | bytearray):
        return value.hex(" ")
    if isinstance(value, Mapping):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(each) for each in value]
    return str(value)
