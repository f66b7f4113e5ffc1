"""A conformance test: every topic is played against one slave, and a verdict says how it ended."""

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import NamedTuple

from canopen_twins.conform import (
    dictionary,
    emcy,
    error_control,
    lss,
    nmt,
    pdo,
    rpdo,
    sdo,
    store,
    sync,
    tpdo,
)
from canopen_twins.conform.bus import Bus
from canopen_twins.conform.tester import Failed, NotApplicable, Slave, Tester
from canopen_twins.conform.topic import Group, Topic, numbered
from canopen_twins.diagnosis.decoder import Decoder
from canopen_twins.diagnosis.sections import sections, table
from canopen_twins.errors import UserError
from canopen_twins.scenario.verdict import Finding, Kind, Outcome, Verdict

FILES = (
    dictionary,
    sdo,
    pdo,
    tpdo,
    rpdo,
    emcy,
    sync,
    error_control,
    store,
    nmt,
    lss,
)
GROUPS: Sequence[Group] = sorted(
    (group for file in FILES for group in file.GROUPS), key=lambda group: group.number
)


def topics() -> list[Topic]:
    """All of them, in their order."""
    return list(numbered(GROUPS))


class Exemption(NamedTuple):
    """What a manual wants otherwise than the standard does."""

    seen: str
    """What the slave has done then, as the topic tells it, or its beginning."""
    reason: str
    source: str


@cache
def exemptions(eds: str) -> Mapping[str, Exemption]:
    """Those of a device by the numbers of the topics: a table beside its EDS, if there is one."""
    rows = table(eds, "conformance")
    return {row["topic"]: Exemption(row["seen"], row["reason"], row["source"]) for row in rows}


def conform(bus: Bus, slave: Slave, wanted: Iterable[Topic] | None = None) -> Verdict:
    """Play topics, all of them if none are named.

    Raises:
        UserError: the slave does not answer at all.
    """
    tester = Tester(bus, slave)
    begun = tester.now
    tester.prepare()
    if not tester.is_answering():
        raise UserError(f"node {slave.node_id} answers no SDO request: is {slave.name} there?")
    outcomes = [_outcome(tester, topic, begun) for topic in wanted or topics()]
    tester.prepare()
    name = f"Conformance of {slave.name}"
    return Verdict(slave.name, tuple(outcomes), name=name, seconds=tester.now - begun)


def _outcome(tester: Tester, topic: Topic, begun: float) -> Outcome:
    tester.prepare()
    kind, seen = _found(tester, topic)
    what = f"{topic.title} [{topic.source}]"
    scene = _scene(tester) if kind is Kind.FAIL else ""
    return Outcome(kind, tester.now - begun, 0, what, seen, scene=scene, topic=topic.number)


def _found(tester: Tester, topic: Topic) -> Finding:
    eds = tester.slave.eds
    try:
        topic.play(tester)
    except NotApplicable as reason:
        return Finding(Kind.SKIP, f"not applicable: {reason} ({_source(topic, reason, eds)})")
    except Failed as failure:
        exempt = exemptions(eds).get(topic.number)
        if exempt is not None and str(failure).startswith(exempt.seen):
            return Finding(Kind.SKIP, f"not applicable: {exempt.reason} ({exempt.source})")
        return Finding(Kind.FAIL, str(failure))
    return Finding(Kind.PASS, "as it should be")


def _source(topic: Topic, reason: NotApplicable, eds: str) -> str:
    """Where the manual tells it; the EDS, where there is no manual."""
    told = sections(eds)
    if reason.index is None:
        return told.service(topic.service) or "EDS"
    return told.object((reason.index, 0)) or told.service("objects") or "EDS"


def _scene(tester: Tester) -> str:
    words = Decoder(()).words
    return "\n".join(f"{frame!s:<22} {words(frame)}".rstrip() for frame in tester.frames)
