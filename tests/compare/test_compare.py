import json
import re

import pytest

from .conftest import compared, log, told, traced
from .masters import supply


def test_a_twin_agrees_with_itself(field, said):
    code, out, err = said("compare", "topcon", "-n", "5", field(supply))
    assert (code, err) == (0, "")
    assert re.fullmatch(r"100 %: (\d+) of \1 agree", out.splitlines()[0])


def test_a_device_that_is_another_is_told_by_object_and_exit_code(field, said):
    code, out, _ = said("compare", "topcon", "-n", "5", field(supply, unit="TCP-16-100"))
    assert code == 1
    assert "SDO 0x2000:00 Nominal voltage: another value, first at " in out


def test_a_trace_without_the_node_is_told_with_those_it_has(field, said):
    code, out, err = said("compare", "topcon", "-n", "6", field(supply))
    assert (code, out) == (2, "")
    assert err == "canopen-twin: the trace has nothing of node 6 (topcon), but of node 5\n"


def test_a_trace_with_too_little_of_the_node_is_told(tmp_path, said):
    trace = log(tmp_path / "little.log", ["(0000000001.000000) can0 705#05"])
    code, _, err = said("compare", "topcon", "-n", "5", trace)
    assert (code, err) == (2, "canopen-twin: the trace has too little of topcon to compare\n")


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


def test_a_program_reads_the_report_as_json(field, said):
    trace = field(supply, serial=7)
    code, out, _ = said("compare", "topcon", "-n", "5", trace, "--json")
    report = json.loads(out)
    assert (code, report["version"], report["total"] - report["agreed"]) == (1, 1, 1)
    (difference,) = report["differences"]
    assert difference["kind"] == "value"
    assert difference["object"] == "0x1018:04 Identity Object.Serial number"
    assert difference["text"] == "7, not 1"
    assert difference["device"][1].endswith(
        "SDO answer 0x1018:04 Identity Object.Serial number = 7"
    )
    assert {row["service"] for row in report["rows"]} >= {"SDO", "TPDO1", "EMCY", "heartbeat"}
    assert "RPDO3" in report["never_exercised"]["topcon"][1]


def test_a_page_holds_the_report(field, said, tmp_path):
    page = tmp_path / "report.html"
    code, out, _ = said("compare", "topcon", "-n", "5", field(supply, serial=7), "--html", page)
    assert code == 1
    assert "never exercised of topcon:\n  NMT reset communication\n  services: RPDO3" in out
    text = page.read_text("utf-8")
    assert '<tr class="differs"><td>topcon SDO 0x1018:04 Identity Object.Serial number</td>' in text
    assert "7, not 1" in text


def test_a_refusal_of_the_twin_is_explained_with_the_section_of_its_manual(field, said):
    trace = field(supply, set_value_range=32767)
    _, out, _ = said("compare", "topcon", "-n", "5", trace)
    assert "  why     605#2B10200004100000 refused: 4100 is above 4000, Voltage reference (" in out


NOISY = {"noise": 3, "load": "resistor 4"}


@pytest.mark.parametrize(
    ("options", "code"),
    [
        ((), 1),
        (("--value", "4"), 0),
        (("--value", "0.001%"), 1),
        (("--tolerances", "objects: {0x2020: 4, Actual current: 4, Actual power: 4}"), 0),
        (("--tolerances", "objects: {0x2020: ignore, 0x2021: ignore, 0x2022: 4}"), 0),
        (("--tolerances", "value: 4"), 0),
        (("--tolerances", "value: 4", "--value", "0"), 1),
    ],
)
def test_values_may_be_off_by_what_the_user_says(field, said, tmp_path, options, code):
    if "--tolerances" in options:
        file = tmp_path / "tolerances.yaml"
        file.write_text(f"version: 1\n{options[1]}\n")
        options = ("--tolerances", file, *options[2:])
    trace = field(supply, **NOISY)
    arguments = ("compare", "topcon", "-n", "5", "--set", "load=resistor 4")
    assert said(*arguments, trace, *options)[0] == code


@pytest.mark.parametrize(("options", "code"), [((), 1), (("--time", "30ms"), 0)])
def test_times_may_be_off_by_what_the_user_says(field, said, options, code):
    trace = field(supply, answer_time=0.02, boot_time=0.02)
    assert said("compare", "topcon", "-n", "5", trace, *options)[0] == code


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--time", "5 parsecs"), "'5 parsecs' is no time: write it as 5ms or 0.005s"),
        (("--value", "x"), "'x' is no tolerance: write 1% of a value, or 3 for digits"),
        (("--tolerances", "none.yaml"), "none.yaml: No such file"),
        (("--html", "no/where.html"), "no/where.html cannot be written: No such file or directory"),
        (("--channel", "can7"), "has no channel can7"),
        (("--columns", "time=1,id=2,data=3"), "is no .csv: leave --columns out"),
    ],
)
def test_nonsense_in_options_is_told_in_a_line(field, said, options, words):
    code, out, err = said("compare", "topcon", "-n", "5", field(supply), *options)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert words in err


def test_mistakes_in_a_file_of_tolerances_have_their_place(field, said, tmp_path):
    file = tmp_path / "tolerances.yaml"
    file.write_text("version: 1\ntime: 5 foot\nobjects: {0x2020: 1, Actual curent: 1}\n")
    code, _, err = said("compare", "topcon", "-n", "5", field(supply), "--tolerances", file)
    assert code == 2
    places = [line.split("tolerances.yaml:")[1][:4] for line in err.splitlines()]
    assert places == ["2:7:", "3:22"]
    assert "did you mean 'Actual current'" in err
