"""A glance at the unit spares its protections: whatever they would say, it may not deny."""

from itertools import product
from math import inf

import pytest

from canopen_twins.devices.topcon.model.protections import (
    is_at_ease,
    is_left_alone,
    of_output,
    of_surroundings,
    warns,
)
from canopen_twins.devices.topcon.model.states import StageState

UNITS = ["TCP-32-400", "TCP-32-400-IBC"]


def around(*levels):
    """Each level, a number just below it and one just above."""
    return [near for level in levels for near in (level - 0.01, level, level + 0.01)]


def holding(rows, stage):
    return [row.error for row in rows if row.condition(stage) and row.armed(stage)]


@pytest.mark.parametrize("name", UNITS)
@pytest.mark.parametrize("state", [StageState.READY, StageState.RUN])
@pytest.mark.parametrize("warnings", [(inf, inf), (380.0, 90.0)])
def test_an_output_at_ease_holds_no_row_and_does_not_warn(power_on, name, state, warnings):
    stage = power_on(name)
    stage.state, (stage.overvoltage_warning, stage.overcurrent_warning) = state, warnings
    rows, seen = list(of_output(stage.unit)), set()
    for values in product(
        around(0.0, 380.0, 440.0),
        around(-110.0, 0.0, 90.0, 110.0),
        around(25.0, 80.0, 95.0),
        around(0.0, 2500.0, 5000.0),
    ):
        stage.circuit.voltage, stage.circuit.current, stage.heat.temperature, stage.store.charge = (
            values
        )
        at_ease, errors = is_at_ease(stage), holding(rows, stage)
        assert not at_ease or not (errors or warns(stage)), values
        seen.add(at_ease)
    assert seen == {False, True}


@pytest.mark.parametrize("name", UNITS)
@pytest.mark.parametrize(
    "wrong",
    [
        {},
        {"supplies": {"24V": 20.0}},
        {"supplies": {"5V": 5.0}},
        {"interlock_closed": False},
        {"slave_silent": True},
        {"sense_offset": -30.0},
        {"sense_offset": 1.0},
        {"sense_reversed": True},
    ],
)
def test_a_unit_left_alone_holds_no_row_of_its_surroundings(power_on, name, wrong):
    stage = power_on(name, units=2)
    stage.step(0.01)
    stage.circuit.voltage = 300.0
    for what, value in wrong.items():
        setattr(stage, what, value)
    rows, seen = list(of_surroundings(stage.unit)), set()
    for stage.mains, stage.mains_before, stage.mains_frequency in product(
        around(340.0, 357.0, 400.0, 437.0, 460.0), (300.0, 400.0, 460.0), around(48.0, 50.0, 62.0)
    ):
        left_alone, errors = is_left_alone(stage), holding(rows, stage)
        assert not left_alone or not (errors or warns(stage)), stage.mains
        seen.add(left_alone)
    assert (True in seen) is not bool(wrong)
