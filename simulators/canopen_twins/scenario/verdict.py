"""What came of a scenario, for people and for programs: as JUnit XML, JSON or flat properties."""

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement


class Kind(StrEnum):
    """How an expectation or a step ended, from good to bad."""

    PASS = "PASS"
    SKIP = "SKIP"
    """It was left out, because of an error before it or because it cannot be done here."""
    FAIL = "FAIL"
    """Something else came than was expected."""
    ERROR = "ERROR"
    """A step could not be carried out, so the run says nothing about who is tested."""


class Finding(NamedTuple):
    """What was decided, and why."""

    kind: Kind
    seen: str


@dataclass(frozen=True)
class Outcome:
    """One expectation, or one step that could not be carried out."""

    kind: Kind
    time: float
    """Seconds of the scenario at which it was decided."""
    line: int
    """Of the file; 0 for what is no part of it, as the master that was started beside it."""
    what: str
    seen: str
    note: str = ""
    scene: str = ""
    """The last frames in words and how the node was then, for what did not pass."""
    node: str = ""
    """Which it is about, by its name in the file; empty if it is about none."""
    topic: str = ""
    """The number of a topic of a conformance test, which is in no line of a file."""

    @property
    def place(self) -> int | str:
        """Where it is expected; 0 if it is no part of a file."""
        return self.topic or self.line


@dataclass(frozen=True)
class Verdict:
    """All outcomes, in the order of the file."""

    file: str
    outcomes: tuple[Outcome, ...]
    name: str = ""
    """Of the scenario."""
    seed: int = 1
    seconds: float = field(default=0.0, compare=False)
    """Of the scenario that have been played."""

    @property
    def kind(self) -> Kind:
        """The worst of all outcomes."""
        order = list(Kind)
        return max((outcome.kind for outcome in self.outcomes), key=order.index, default=Kind.PASS)

    @property
    def ok(self) -> bool:
        """Whether everything that was not left out has come as expected."""
        return self.kind in (Kind.PASS, Kind.SKIP)

    def __str__(self) -> str:
        """A line for the whole, one for each outcome, and the scene of what did not pass."""
        counts = {kind: sum(kind is each.kind for each in self.outcomes) for kind in Kind}
        found = ", ".join(f"{count} {kind}" for kind, count in counts.items() if count)
        lines = [f"{self.file}: {self.kind} ({found or 'nothing was expected'})"]
        for outcome in self.outcomes:
            lines += self._lines(outcome)
        return "\n".join(lines)

    def _lines(self, outcome: Outcome) -> list[str]:
        head = f"  {outcome.kind:5} {outcome.time:12.6f} s  {_told(self, outcome)}"
        lines = [head]
        if outcome.scene:
            note = [f"note: {outcome.note}"] if outcome.note else []
            lines += [f"        {line}" for line in (*note, *outcome.scene.splitlines())]
        return lines


def _told(verdict: Verdict, outcome: Outcome) -> str:
    """One outcome with its place, its node, what was wanted and what came."""
    place = f"{verdict.file}:{outcome.place}" if outcome.place else verdict.file
    return ": ".join(filter(None, (place, outcome.node, outcome.what, outcome.seen)))


def _summary(verdict: Verdict) -> Iterator[tuple[str, str]]:
    yield "canopen_scenario", verdict.file
    yield "canopen_verdict", verdict.kind.value
    for kind in Kind:
        count = sum(outcome.kind is kind for outcome in verdict.outcomes)
        yield f"canopen_{kind.lower()}", str(count)
    yield "canopen_seed", str(verdict.seed)
    yield "canopen_seconds", f"{verdict.seconds:.6f}"


def as_properties(verdict: Verdict) -> Iterator[tuple[str, str]]:
    """Names with values: of the whole, and a `canopen_outcome` for each that did not pass."""
    yield from _summary(verdict)
    for each in verdict.outcomes:
        if each.kind is not Kind.PASS:
            yield "canopen_outcome", f"{each.kind} {each.time:.6f} s {_told(verdict, each)}"


VERSION = 1  # of the JSON


def as_json(verdicts: Sequence[Verdict]) -> str:
    """In one line, for whoever reads line by line."""
    return json.dumps(
        {
            "version": VERSION,
            "verdict": max((each.kind for each in verdicts), key=list(Kind).index).value,
            "scenarios": [as_object(verdict) for verdict in verdicts],
        }
    )


def as_object(verdict: Verdict) -> Mapping[str, object]:
    """One scenario of the JSON."""
    return {
        "file": verdict.file,
        "name": verdict.name,
        "verdict": verdict.kind.value,
        "seed": verdict.seed,
        "duration": verdict.seconds,
        "outcomes": [_outcome(outcome) for outcome in verdict.outcomes],
    }


def _outcome(outcome: Outcome) -> Mapping[str, object]:
    return {
        "verdict": outcome.kind.value,
        "time": outcome.time,
        "line": outcome.place,
        "what": outcome.what,
        "seen": outcome.seen,
        "note": outcome.note,
        "node": outcome.node,
        "scene": outcome.scene,
    }


NO_XML = re.compile("[^\t\n\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
HEAD = '<?xml version="1.0" encoding="utf-8"?>\n'

ELEMENTS = {Kind.SKIP: "skipped", Kind.FAIL: "failure", Kind.ERROR: "error"}
"""What stands in a case that did not pass."""


def as_junit(verdicts: Sequence[Verdict]) -> str:
    """JUnit XML; times are simulated seconds, those of a case when it was decided."""
    suites = Element("testsuites", _counts([*verdicts]), name="canopen-twin")
    for verdict in verdicts:
        suites.append(_suite(verdict))
    ElementTree.indent(suites)
    return f"{HEAD}{ElementTree.tostring(suites, encoding='unicode')}\n"


def _suite(verdict: Verdict) -> Element:
    skipped = sum(outcome.kind is Kind.SKIP for outcome in verdict.outcomes)
    suite = Element("testsuite", _counts([verdict]), skipped=str(skipped))
    suite.set("name", _clean(verdict.name or verdict.file))
    properties = SubElement(suite, "properties")
    for name, value in _summary(verdict):
        SubElement(properties, "property", name=name, value=_clean(value))
    seen: Counter[str] = Counter()
    for outcome in verdict.outcomes:
        told = (outcome.topic, outcome.node, outcome.note or outcome.what)
        name = ": ".join(filter(None, told))
        seen[name] += 1
        case = SubElement(suite, "testcase", time=f"{outcome.time:.6f}")
        case.set("classname", _clean(verdict.file))
        case.set("name", _clean(name if seen[name] == 1 else f"{name} ({seen[name]})"))
        _result(case, verdict, outcome)
    return suite


def _result(case: Element, verdict: Verdict, outcome: Outcome) -> None:
    if outcome.kind in ELEMENTS:
        result = SubElement(case, ELEMENTS[outcome.kind], type=outcome.kind.value)
        result.set("message", _clean(outcome.seen))
        place = _told(verdict, outcome)
        result.text = _clean("\n".join(filter(None, (place, outcome.note, outcome.scene))))


def _counts(verdicts: Sequence[Verdict]) -> dict[str, str]:
    kinds = Counter(outcome.kind for verdict in verdicts for outcome in verdict.outcomes)
    return {
        "tests": str(kinds.total()),
        "failures": str(kinds[Kind.FAIL]),
        "errors": str(kinds[Kind.ERROR]),
        "time": f"{sum(verdict.seconds for verdict in verdicts):.3f}",
    }


def _clean(text: str) -> str:
    """Without what XML cannot say, not even escaped."""
    return NO_XML.sub(lambda match: f"\\x{ord(match[0]):02x}", text)
