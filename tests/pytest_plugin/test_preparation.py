import sys

import pytest

from canopen_twins import devices
from canopen_twins.pytest_plugin import prepare


@pytest.fixture
def imported(pytester):
    """What of ours a process has imported before its first test, with a test of this head."""

    def imported(head):
        pytester.makeconftest(
            """
            import sys

            def pytest_runtestloop(session):
                names = [name for name in sys.modules if name.startswith("canopen_twins.")]
                print("imported:", *names)
            """
        )
        pytester.makepyfile(f"def test_it({head}): pass")
        result = pytester.runpytest_subprocess("-s", "-p", "no:cacheprovider")
        result.assert_outcomes(passed=1)
        (line,) = [line for line in result.outlines if line.startswith("imported:")]
        return set(line.split()[1:])

    return imported


def test_a_test_without_our_fixtures_imports_nothing(imported):
    assert "canopen_twins.bus.segment" not in imported("tmp_path")


def test_the_fixture_of_a_device_has_it_imported_and_read_before_the_first_test(imported):
    names = imported("topcon")
    assert "canopen_twins.devices.topcon" in names
    assert "canopen_twins.devices.charger" not in names
    assert "canopen_twins.live.twin" not in names


def test_a_fixture_for_any_device_has_all_of_them_there(imported):
    assert {
        "canopen_twins.devices.topcon",
        "canopen_twins.devices.charger",
        "canopen_twins.devices.gateway",
        "canopen_twins.live.twin",
    } <= imported("canopen_device")


def test_a_list_of_tests_is_made_without(pytester):
    pytester.makepyfile("def test_it(topcon): pass")
    pytester.makeconftest(
        """
        import sys

        def pytest_unconfigure():
            print("there:", "canopen_twins.bench.bench" in sys.modules)
        """
    )
    result = pytester.runpytest_subprocess("--collect-only", "-q", "-s")
    result.stdout.fnmatch_lines(["there: False"])


def test_a_device_that_is_broken_is_told_to_whoever_asks_for_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "canopen_twins.devices.topcon", None)
    prepare([{"topcon", "canopen_bench"}])  # says nothing: no test may want it
    with pytest.raises(ImportError, match=r"canopen_twins\.devices\.topcon"):
        devices.find("topcon")
