from dataclasses import fields

import pytest

from canopen_twins.devices.topcon.unit_file import read_unit_types
from canopen_twins.devices.topcon.units import shipped
from canopen_twins.errors import UserError

A = "TCP-32-400"


@pytest.fixture
def read(units, tmp_path):
    """Reads a file with the figures of a shipped unit type, a line each; None leaves one out."""

    def read(head="version: 1\ntypes:", count=1, **changes):
        told = {field.name: getattr(units[A], field.name) for field in fields(units[A])}
        lines = [f"{key}: {value}" for key, value in (told | changes).items() if value is not None]
        entry = "\n  - " + "\n    ".join(lines).replace("False", "false")
        path = tmp_path / "units.yaml"
        path.write_text(head + entry * count)
        return read_unit_types(path)

    return read


def test_our_file_says_line_by_line_what_it_says_as_yaml(units):
    assert repr(shipped()) == repr(units)  # whole numbers are whole in both


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"nominal_volltage": 4}, "unknown key 'nominal_volltage': did you mean"),
        ({"bleeder": None}, "3:5: 'bleeder' is missing"),
        ({"name": None, "bleeder": None}, "3:5: 'name', 'bleeder' are missing"),
        ({"capacitance": "5e-4 F"}, "8:18: '5e-4 F' is no number"),
        ({"bleeder": "true"}, "9:14: 'true' is no number"),
        ({"regenerative": "yes"}, ": 'yes' is neither true nor false"),
        ({"nominal_power": 32500}, "3:5: unit type 'TCP-32-400': nominal_power must be a whole"),
        ({"head": "version: 2\ntypes:"}, "1:10: version 2 is unknown; this is 1"),
        ({"head": "types:"}, "1:1: 'version' is missing"),
        ({"head": "version: 1\ntype:"}, "2:1: unknown key 'type': did you mean 'types'?"),
        ({"head": "version: 1\ntypes: [TCP]\n#", "count": 0}, "2:9: a key with a value"),
        ({"head": "version: 1\ntypes: TCP\n#", "count": 0}, "2:8: a list is wanted here"),
        ({"head": "version: 1\ntypes: []\n#", "count": 0}, "2:8: empty"),
        ({"count": 2}, ": unit type 'TCP-32-400' stands above already"),
    ],
    ids=str,
)
def test_what_is_wrong_is_told_with_its_place(read, changes, told):
    with pytest.raises(UserError) as refusal:
        read(**changes)
    assert told in str(refusal.value)


def test_everything_that_is_wrong_is_told_at_once(read):
    with pytest.raises(UserError) as refusal:
        read(bleeder="much", efficiency="little", idle_power=None)
    assert [line.split(": ", 1)[1] for line in str(refusal.value).splitlines()] == [
        "'idle_power' is missing",
        "'much' is no number; numbers look like 16, 0x10 or 0.5",
        "'little' is no number; numbers look like 16, 0x10 or 0.5",
    ]


def test_what_has_a_default_may_be_left_out(read, units):
    assert read(sink_current=None, regenerative=None) == {A: units[A]}


def test_a_number_may_have_an_exponent(read):
    assert read(capacitance="4e-4")[A].capacitance == 0.0004
