from itertools import product
from math import inf

import pytest

from canopen_twins.devices.topcon.model.circuit import Law, solve
from canopen_twins.devices.topcon.model.loads import (
    Battery,
    CurrentSink,
    Inductor,
    Open,
    Resistor,
    Short,
)
from canopen_twins.devices.topcon.model.states import Mode

BLEEDER = 1 / 2000
LOADS = [
    Open(),
    Resistor(4.0),
    Short(),
    Battery(350, 0.1),
    Battery(350, 0.1, diode=True),
    CurrentSink(30.0),
    Inductor(2.0, 0.01),
]
LAWS = [
    Law(voltage, resistance, current, power, sink)
    for voltage, resistance, current, power, sink in product(
        (0.0, 200.0, 400.0), (1e-4, 4.0), (0.0, 25.0, 100.0), (0.0, 2e3, 32e3), (0.0, 50.0)
    )
]


def excess(law, before, storage, line, voltage):
    """What storage, bleeder and load take at a voltage, less what the converter gives there."""
    conductance, offset, low, high = line
    load = min(max(conductance * voltage + offset, low), high)
    given = 0.0
    if law:
        by_voltage = (law.voltage - voltage) / law.resistance
        by_power = law.power / voltage if voltage > 0 else inf
        limit = min(by_voltage, law.current, by_power)
        floor = voltage * BLEEDER - law.sink if law.sink else 0.0
        given = max(floor, limit + voltage * BLEEDER)
    return storage * (voltage - before) + voltage * BLEEDER + load - given


@pytest.mark.parametrize("load", LOADS, ids=str)
@pytest.mark.parametrize("before", [0.0, 0.5, 150.0, 400.0])
def test_the_voltage_is_where_the_balance_changes_its_sign(load, before):
    for law, storage, current in product([None, *LAWS], (0.5, 5.0, 50.0), (0.0, 40.0)):
        line = load.line(before, current, 0.001)
        voltage = solve(law, before, storage, BLEEDER, line).voltage
        hair = 1e-9 * max(1.0, voltage)
        assert excess(law, before, storage, line, voltage + hair) > 0
        if voltage > 0.0:  # else the rectifier holds it there
            assert excess(law, before, storage, line, voltage - hair) < 0


@pytest.mark.parametrize("load", LOADS, ids=str)
def test_the_mode_names_the_limit_that_binds_at_the_root(load):
    for law in LAWS:
        voltage, _, mode = solve(law, 150.0, 0.5, BLEEDER, load.line(150.0, 0.0, 0.001))
        if voltage <= 0.0:
            continue  # freewheeling: all limits are beyond reach
        currents = {
            Mode.VOLTAGE: (law.voltage - voltage) / law.resistance,
            Mode.CURRENT: law.current,
            Mode.POWER: law.power / voltage,
        }
        least = min(currents.values())
        if law.sink and least < -law.sink - 1e-5:
            assert mode is Mode.CURRENT  # what it takes in is limited
        else:
            assert currents[mode] == pytest.approx(least, abs=1e-5)


def test_charge_is_conserved():
    voltage, storage = 400.0, 0.5
    for _ in range(20):
        line = Resistor(3.0).line(voltage, 0.0, 0.001)
        after, current, _ = solve(None, voltage, storage, BLEEDER, line)
        assert storage * (voltage - after) == pytest.approx(current + after * BLEEDER)
        voltage = after


def test_a_converter_that_is_off_has_no_mode():
    assert solve(None, 10.0, 0.5, BLEEDER, Open().line(10.0, 0.0, 0.001)).mode is Mode.OFF
