import pytest

from .conftest import compared, log, told, traced
from .masters import supply


def test_a_twin_agrees_with_itself(field, said):
    code, out, err = said("compare", "topcon", "-n", "5", field(supply))
    assert (code, err) == (0, "")
    assert out.splitlines()[0] == "100 %: 199 of 199 agree"


def test_a_device_that_is_another_is_told_by_object_and_exit_code(field, said):
    code, out, _ = said("compare", "topcon", "-n", "5", field(supply, unit="TCP-16-100"))
    assert code == 1
    assert "SDO 0x2000:00 Nominal voltage: another value, first at " in out


def test_a_trace_without_the_node_is_told_with_those_it_has(field, said):
    code, out, err = said("compare", "topcon", "-n", "6", field(supply))
    assert (code, out) == (2, "")
    assert err == "canopen-twin: the trace has nothing of node 6 (topcon), but of node 5\n"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("topcom", "-n", "5"), "did you mean 'topcon'"),
        (("topcon", "-n", "200"), "node id 200 is not in 1..127"),
        (("topcon", "--set", "unit=none"), "none"),
    ],
)
def test_nonsense_is_told_in_a_line(field, said, arguments, words):
    code, out, err = said("compare", *arguments, field(supply))
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert words in err


def test_a_trace_of_nothing_is_told(tmp_path, said):
    code, _, err = said("compare", "topcon", log(tmp_path / "empty.log", []))
    assert (code, err) == (2, "canopen-twin: the trace has nothing of node 1 (topcon)\n")


def test_a_slow_twin_is_told_by_its_times_alone():
    records = traced(supply)
    agreement = compared(records, boot_time=2.0, answer_time=0.05)
    assert set(told(agreement)) == {
        "boot-up: another time",
        "SDO answer time: another time",
        "SDO 0x1010:01 Store Parameters.Storage functionality/Storage command: another time",
    }


@pytest.mark.parametrize(
    "settings",
    [
        {"timing": "typical"},
        {"timing": "worst", "noise": 3},
        {"measure_time": 0.3, "load": "resistor 4"},
        {"store_time": 0.3, "store_busy": "refuses", "boot_time": 0.4},
        {"answer_time": 0.01, "answer_jitter": 0.02, "unit": "TCP-16-100"},
    ],
)
def test_a_twin_with_settings_agrees_with_itself(settings):
    agreement = compared(traced(supply, **settings), **settings)
    assert (told(agreement), agreement.share) == ([], 1.0)
