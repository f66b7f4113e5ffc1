"""Verdicts for programs: JUnit XML, JSON, and flat properties of a test."""

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from canopen_twins.scenario import Kind, Outcome, Verdict

Pair = tuple[str, str]


def summary(verdict: Verdict) -> Iterator[Pair]:
    """What came of the whole."""
    yield "canopen_scenario", verdict.file
    yield "canopen_verdict", verdict.kind.value
    for kind in Kind:
        count = sum(outcome.kind is kind for outcome in verdict.outcomes)
        yield f"canopen_{kind.lower()}", str(count)
    yield "canopen_seed", str(verdict.seed)
    yield "canopen_seconds", f"{verdict.seconds:.6f}"


def properties(verdict: Verdict) -> Iterator[Pair]:
    """The same, and a `canopen_outcome` for each outcome that did not pass."""
    yield from summary(verdict)
    for each in verdict.outcomes:
        if each.kind is not Kind.PASS:
            told = f"{each.kind} {each.time:.6f} s {verdict.file}:{each.line}"
            yield "canopen_outcome", f"{told}: {each.what}: {each.seen}"


VERSION = 1


def document(verdicts: Sequence[Verdict]) -> str:
    """In one line, for whoever reads line by line."""
    return json.dumps(
        {
            "version": VERSION,
            "verdict": max((each.kind for each in verdicts), key=list(Kind).index).value,
            "scenarios": [_scenario(verdict) for verdict in verdicts],
        }
    )


def _scenario(verdict: Verdict) -> Mapping[str, object]:
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
        "line": outcome.line,
        "what": outcome.what,
        "seen": outcome.seen,
        "note": outcome.note,
        "scene": outcome.scene,
    }


NO_XML = re.compile("[^\t\n\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
HEAD = '<?xml version="1.0" encoding="utf-8"?>\n'

ELEMENTS = {Kind.SKIP: "skipped", Kind.FAIL: "failure", Kind.ERROR: "error"}
"""What stands in a case that did not pass."""


def junit(verdicts: Sequence[Verdict]) -> str:
    """The document; times are simulated seconds, those of a case when it was decided."""
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
    for name, value in summary(verdict):
        SubElement(properties, "property", name=name, value=_clean(value))
    told: Counter[str] = Counter()
    for outcome in verdict.outcomes:
        name = f"{outcome.line}: {outcome.what}"
        told[name] += 1
        case = SubElement(suite, "testcase", time=f"{outcome.time:.6f}")
        case.set("classname", _clean(verdict.file))
        case.set("name", _clean(name if told[name] == 1 else f"{name} ({told[name]})"))
        _result(case, outcome)
    return suite


def _result(case: Element, outcome: Outcome) -> None:
    if outcome.kind in ELEMENTS:
        result = SubElement(case, ELEMENTS[outcome.kind], type=outcome.kind.value)
        result.set("message", _clean(outcome.seen))
        result.text = _clean("\n".join(filter(None, (outcome.note, outcome.scene))))


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
