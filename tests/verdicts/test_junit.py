from dataclasses import replace
from xml.etree import ElementTree

import pytest

from canopen_twins.scenario import Kind, Outcome, Verdict
from canopen_twins.scenario.verdict import as_junit

COUNTS = {"tests", "failures", "errors", "time", "name"}
ATTRIBUTES = {  # those that every description of the format has in common
    "testsuites": COUNTS,
    "testsuite": COUNTS | {"skipped"},
    "property": {"name", "value"},
    "testcase": {"classname", "name", "time"},
    "failure": {"type", "message"},
    "error": {"type", "message"},
    "skipped": {"type", "message"},
    "properties": set(),
}
CHILDREN = {
    "testsuites": {"testsuite"},
    "testsuite": {"properties", "testcase"},
    "properties": {"property"},
    "testcase": {"failure", "error", "skipped"},
}


def told(*verdicts):
    return ElementTree.fromstring(as_junit(verdicts))


def test_it_has_the_elements_and_attributes_of_the_format(verdict):
    for element in told(verdict, verdict).iter():
        assert set(element.attrib) == ATTRIBUTES[element.tag]
        assert {child.tag for child in element} <= CHILDREN.get(element.tag, set())


def test_a_scenario_is_a_suite_and_an_outcome_is_a_case(verdict):
    (suite,) = told(verdict)
    assert suite.get("name") == "Everything at once"
    assert [
        (case.get("classname"), case.get("name"), case.get("time"), [each.tag for each in case])
        for case in suite.iter("testcase")
    ] == [
        ("stories/all.yaml", "705#00 at once", "0.100000", []),
        ("stories/all.yaml", "topcon: A note.", "0.250000", ["failure"]),
        ("stories/all.yaml", "write X = 3", "2.000000", ["error"]),
        ("stories/all.yaml", "write X = 3 (2)", "3.000000", ["error"]),
        ("stories/all.yaml", "nmt", "3.000000", ["skipped"]),
    ]


def test_what_did_not_pass_is_told_with_what_came_its_note_and_its_scene(verdict):
    failure = told(verdict).find(".//failure")
    assert failure.attrib == {"type": "FAIL", "message": "2300/03/23"}
    assert failure.text == (
        "stories/all.yaml:6: topcon: no EMCY for 1 s: 2300/03/23\n"
        f"A note.\n{verdict.outcomes[1].scene}"
    )


def test_the_kinds_are_counted_apart(verdict):
    suites = told(verdict, verdict)
    assert suites[0].attrib == {
        "name": "Everything at once",
        "tests": "5",
        "failures": "1",
        "errors": "2",
        "skipped": "1",
        "time": "12.500",
    }
    assert (suites.get("tests"), suites.get("errors"), suites.get("time")) == ("10", "4", "25.000")


def test_the_properties_are_those_that_pytest_gets(verdict):
    pairs = {each.get("name"): each.get("value") for each in told(verdict).iter("property")}
    assert pairs == {
        "canopen_scenario": "stories/all.yaml",
        "canopen_verdict": "ERROR",
        "canopen_pass": "1",
        "canopen_skip": "1",
        "canopen_fail": "1",
        "canopen_error": "2",
        "canopen_seed": "7",
        "canopen_seconds": "12.500000",
    }


def test_a_scenario_that_expects_nothing_has_no_case():
    (suite,) = told(Verdict("quiet.yaml", ()))
    assert (suite.get("name"), suite.get("tests")) == ("quiet.yaml", "0")


@pytest.mark.parametrize("text", ["\x00\x1b[1m\r", "\ufffe", "\udc80", "<&>\"']]>", "\U0001f50c ä"])
def test_any_text_makes_a_document(verdict, text):
    outcome = Outcome(Kind.FAIL, 0.0, 1, text, text, text, text, text)
    odd = replace(verdict, file=text, name=text, outcomes=(outcome,))
    (suite,) = ElementTree.fromstring(as_junit([odd]).encode("utf-8"))
    readable = suite.get("name")
    assert suite.find("testcase").get("classname") == readable
    place = f"{readable}:1: {readable}: {readable}: {readable}"
    assert suite.find(".//failure").text == f"{place}\n{readable}\n{readable}"
    assert readable == text or "\\x" in readable
