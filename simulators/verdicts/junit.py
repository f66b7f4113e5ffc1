"""Verdicts as JUnit XML, which every CI server shows: a suite per scenario, a case per outcome."""

import re
from collections import Counter
from collections.abc import Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from simulators.replay import Kind, Outcome, Verdict
from simulators.verdicts.properties import summary

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
