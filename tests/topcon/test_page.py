import re
from pathlib import Path

import pytest

from canopen_twins.devices.topcon.model.loads import LOADS, parse_load
from canopen_twins.devices.topcon.model.states import TRANSITIONS

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "devices" / "topcon.md").read_text("utf-8")
PINS = {2: "CAN-L", 3: "CAN GND", 5: "shield", 6: "GND (CAN GND)", 7: "CAN-H"}


@pytest.mark.spec("T-008")
@pytest.mark.parametrize("pin", range(1, 10))
def test_the_pins_of_the_plug_are_told(pin):
    assert f"| {pin} | {PINS.get(pin, 'not assigned')} |" in PAGE
    assert "connected 1:1" in PAGE


def test_the_picture_of_the_states_is_that_of_the_table():
    drawn = set(re.findall(r"^    (\w+) --> (\w+): (\w+)$", PAGE, re.MULTILINE))
    assert drawn == {
        (state.name, after.name, event.name.lower())
        for state, row in TRANSITIONS.items()
        for event, after in row.items()
    }


def test_every_load_is_told_as_it_can_be_written():
    loads = re.findall(r"^\| `([a-z]+(?: [^`]+)?)` \| (?!`)", PAGE, re.MULTILINE)
    written = [load for load in loads if load.split()[0] in LOADS]
    assert {parse_load(load).word for load in written} == set(LOADS)


def test_the_unit_types_are_told_with_their_figures(units):
    for name, unit in units.items():
        (row,) = re.findall(rf"^\| `{name}`.*$", PAGE, re.MULTILINE)
        kilowatt, milliohm = unit.nominal_power / 1e3, unit.nominal_resistance * 1e3
        assert f"| {unit.nominal_voltage} V | {unit.maximum_current} A |" in row
        assert f"| {kilowatt:.0f} kW | {milliohm:.0f} mOhm |" in row


def test_every_assumption_is_told_once_and_says_how_to_change_it_or_why_not():
    rows = re.findall(r"^\| A-(\d+) \| .* \| (.*) \|$", PAGE, re.MULTILINE)
    assert [int(number) for number, _ in rows] == list(range(1, len(rows) + 1))
    for number, setting in rows:
        assert setting.startswith(("fixed: ", "`")), number


def test_every_assumption_the_code_names_is_told():
    told = set(re.findall(r"^\| (A-\d+) \|", PAGE, re.MULTILINE))
    files = [
        *ROOT.glob("simulators/canopen_twins/devices/topcon/**/*.py"),
        *ROOT.glob("od/topcon*"),
    ]
    named = {number for file in files for number in re.findall(r"A-\d\d", file.read_text("utf-8"))}
    assert named <= told
    tests = (file.read_text("utf-8") for file in ROOT.glob("tests/topcon/*.py"))
    assert {number for text in tests for number in re.findall(r"\"(A-\d\d)\"", text)} <= told
