import subprocess
import sys

import pytest

from canopen_twins.pytest_plugin import judge
from canopen_twins.scenario import Kind, Outcome, Verdict

from .steps import BROKEN, FAILING, PASSING


@pytest.fixture
def stories(story):
    """One file of every verdict."""
    story("good.twin.yaml", PASSING, "It is as it should be")
    story("bad.twin.yaml", FAILING, "It is not")
    story("deep/broken.twin.yml", BROKEN, "Nobody knows")


def test_every_file_is_a_test_with_an_outcome_of_its_own(run, stories):
    result = run(None)
    result.assert_outcomes(passed=1, failed=1, errors=1)
    assert result.ret == pytest.ExitCode.TESTS_FAILED


def test_what_failed_is_told_in_the_words_of_the_verdict_alone(run, stories):
    result = run(None, "bad.twin.yaml")
    text = result.stdout.str()
    result.stdout.fnmatch_lines(
        [
            "*_ It is not _*",
            "bad.twin.yaml: FAIL (1 FAIL)",
            "  FAIL      0.100000 s  bad.twin.yaml:5: topcon: Nominal voltage 401 at once: *is 400",
            "*705#00*boot-up",
            "*topcon: node 5, PRE-OPERATIONAL",
            "FAILED bad.twin.yaml::It is not - *bad.twin.yaml: FAIL (1 FAIL)",
        ]
    )
    assert "Traceback" not in text
    assert ".py" not in text.split("= FAILURES =")[1]


def test_what_could_not_be_told_is_an_error_and_no_failure(run, stories):
    result = run(None, "deep")
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(
        [
            "*ERROR at setup of Nobody knows*",
            "deep/broken.twin.yml: ERROR (1 ERROR)",
            "ERROR deep/broken.twin.yml::Nobody knows - *",
        ]
    )


def test_a_file_with_mistakes_cannot_be_collected_and_says_where(run, story):
    story("good.twin.yaml", PASSING)
    story("wrong.twin.yaml", "- {at: 1, expct: 1}\n- {at: 0, nmt: strat}")
    result = run(None)
    result.assert_outcomes(errors=1)
    lines = result.stdout.str().split("ERRORS =")[1].splitlines()
    told = lines[2 : next(number for number, line in enumerate(lines) if "short test" in line)]
    assert told == [
        "wrong.twin.yaml:5:11: unknown key 'expct': did you mean 'expect'?",
        "wrong.twin.yaml:6:8: 0 s is before 1 s, of a step above",
        "wrong.twin.yaml:6:16: unknown NMT command 'strat': did you mean 'start'?",
    ]


def test_they_are_found_by_name_file_device_and_node_id(run, stories):
    assert run(None, "--collect-only", "-q").stdout.lines[:3] == [
        "bad.twin.yaml::It is not",
        "deep/broken.twin.yml::Nobody knows",
        "good.twin.yaml::It is as it should be",
    ]
    run(None, "-k", "should").assert_outcomes(passed=1, deselected=2)
    run(None, "-k", "good.twin").assert_outcomes(passed=1, deselected=2)
    run(None, "-k", "topcon and not deep and not bad").assert_outcomes(passed=1, deselected=2)
    run(None, "good.twin.yaml::It is as it should be").assert_outcomes(passed=1)


def test_a_scenario_without_a_name_has_that_of_its_file(run, story):
    story("good.twin.yaml", PASSING, '" "')
    run(None, "good.twin.yaml::good.twin").assert_outcomes(passed=1)


def test_it_is_found_by_what_it_covers(run, story, pytester):
    story("good.twin.yaml", PASSING)
    file = pytester.path / "covering.twin.yaml"
    file.write_text((pytester.path / "good.twin.yaml").read_text() + "covers: [T-193]\n")
    run(None, "-k", "T-193").assert_outcomes(passed=1, deselected=1)


def test_a_name_that_would_split_a_node_id_does_not(run, story):
    story("odd.twin.yaml", PASSING, '"Odd::name,\\n [in] parts"')
    (told,) = [line for line in run(None, "--collect-only", "-q").stdout.lines if "odd" in line]
    assert told == "odd.twin.yaml::Odd:name, [in] parts"
    run(None, told).assert_outcomes(passed=1)


def test_what_is_left_out_is_skipped_with_its_reason():
    left_out = Outcome(Kind.SKIP, 1.0, 7, "nmt", "only on the simulated bus")
    skipped = Verdict("story.yaml", (Outcome(Kind.PASS, 0.0, 5, "", ""), left_out))
    with pytest.raises(pytest.skip.Exception, match=r"story.yaml:7: only on the simulated bus"):
        judge([Verdict("good.yaml", ()), skipped])


def test_nothing_that_is_left_out_hides_a_failure():
    skipped, failed = (
        Verdict(f"{kind}.yaml", (Outcome(kind, 1.0, 7, "", ""),)) for kind in (Kind.SKIP, Kind.FAIL)
    )
    with pytest.raises(pytest.fail.Exception, match=r"FAIL\.yaml: FAIL"):
        judge([skipped, failed])


def test_other_files_are_left_alone(run, story):
    story("plain.yaml", FAILING)
    assert run(None).ret == pytest.ExitCode.NO_TESTS_COLLECTED


def test_nothing_of_can_is_imported_without_a_file(pytester):
    pytester.makepyfile(
        """
        import sys

        def test_nothing():
            assert {"can", "canopen", "yaml", "canopen_twins.bench.bench"}.isdisjoint(sys.modules)
        """
    )
    done = subprocess.run([sys.executable, "-m", "pytest", "-q"], check=False)
    assert done.returncode == 0
