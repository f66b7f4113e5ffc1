from xml.etree import ElementTree

import pytest

from .steps import BROKEN, FAILING, PASSING


@pytest.fixture
def report(run, pytester):
    """Every test case of pytest's own XML report, by its name."""

    def report(source, *options):
        run(source, "--junitxml=report.xml", *options)
        cases = ElementTree.parse(pytester.path / "report.xml").iter("testcase")
        return {case.get("name"): case for case in cases}

    return report


def told(case):
    return [(each.get("name"), each.get("value")) for each in case.iter("property")]


def test_a_story_leaves_what_came_of_it_in_the_report(report, story):
    story("two.twin.yaml", f"{PASSING}\n{FAILING}\nseed: 7", "Two things")
    case = report(None)["Two things"]
    assert told(case) == [
        ("canopen_scenario", "two.twin.yaml"),
        ("canopen_verdict", "FAIL"),
        ("canopen_pass", "1"),
        ("canopen_skip", "0"),
        ("canopen_fail", "1"),
        ("canopen_error", "0"),
        ("canopen_seed", "7"),
        ("canopen_seconds", "0.100001"),
        (
            "canopen_outcome",
            "FAIL 0.100000 s two.twin.yaml:6: topcon:"
            " Nominal voltage 401 at once: Nominal voltage is 400",
        ),
    ]


def test_failures_and_errors_are_different_elements(report, story):
    story("good.twin.yaml", PASSING, "Good")
    story("bad.twin.yaml", FAILING, "Bad")
    story("broken.twin.yaml", BROKEN, "Broken")
    cases = report(None)
    assert [each.tag for each in cases["Good"]] == ["properties"]
    assert [each.tag for each in cases["Bad"]] == ["properties", "failure"]
    assert [each.tag for each in cases["Broken"]] == ["properties", "error"]
    assert "bad.twin.yaml: FAIL (1 FAIL)" in cases["Bad"].find("failure").text


def test_a_test_that_lives_through_stories_leaves_all_of_them(report, story):
    story("good.yaml", PASSING)
    story("bad.yaml", FAILING)
    case = report("""
        def test_two(canopen_scenario):
            canopen_scenario("bad.yaml")
            canopen_scenario("good.yaml").run(60)
    """)["test_two"]
    assert [value for name, value in told(case) if name == "canopen_verdict"] == ["FAIL", "PASS"]
    assert [value for name, value in told(case) if name == "canopen_seconds"][1] == "60.000000"
    assert case.find("failure").text.startswith("bad.yaml: FAIL (1 FAIL)")


def test_a_test_that_fails_by_itself_leaves_them_as_they_are_then(report, story):
    story("bad.yaml", FAILING)
    case = report("""
        def test_it(canopen_scenario):
            canopen_scenario("bad.yaml").run(1)
            assert False
    """)["test_it"]
    assert ("canopen_verdict", "FAIL") in told(case)
    assert ("canopen_seconds", "1.000000") in told(case)


def test_it_is_the_same_under_xdist(report, story, pytester):
    story("bad.twin.yaml", FAILING, "Bad")
    alone = told(report(None)["Bad"])
    pytester.runpytest_subprocess("-n2", "--junitxml=report.xml")
    (case,) = ElementTree.parse(pytester.path / "report.xml").iter("testcase")
    assert told(case) == alone
    assert case.find("failure") is not None


def test_an_attempt_is_judged_by_itself(report, story):
    story("good.yaml", PASSING)
    case = report(
        """
        attempts = []

        def test_it(canopen_scenario):
            attempts.append(canopen_scenario("good.yaml"))
            assert len(attempts) == 2, "as it fails for the first time"
        """,
        "--reruns=1",
    )["test_it"]
    assert [each.tag for each in case] == ["properties"]
    assert [value for name, value in told(case) if name == "canopen_verdict"] == ["PASS"]


def test_a_story_that_fails_is_played_again(report, story):
    story("bad.twin.yaml", FAILING, "Bad")
    case = report(None, "--reruns=1")["Bad"]
    assert case.find("failure") is not None
    assert [value for name, value in told(case) if name == "canopen_verdict"] == ["FAIL"]
