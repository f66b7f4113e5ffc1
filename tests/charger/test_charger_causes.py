from dataclasses import replace

import pytest

from canopen_twins.devices.charger.model.load import SHORT
from canopen_twins.devices.charger.model.types import PCSC, Variant

THRESHOLDS = [
    ("power_stage", 75, 85),
    ("inside", 60, 70),
    ("cascade", 70, 80),
    ("discharging", 70, 80),
]


def clear(charger, key):
    message = next(message for message in charger.messages.active if message.key == key)
    charger.clear(message.severity, message.number)


@pytest.mark.parametrize(
    ("supply", "told"),
    [
        (17.0, [("WARNING", "supply_low"), ("ERROR", "supply_low")]),
        (19.0, [("WARNING", "supply_low")]),
        (24.0, []),
        (29.0, [("WARNING", "supply_high")]),
        (31.0, [("WARNING", "supply_high"), ("ERROR", "supply_high")]),
    ],
)
def test_a_bad_supply_is_told(charger, active, supply, told):
    charger.surround(supply_voltage=supply)
    charger.step(0.2)
    assert active(charger) == told


def test_the_supply_may_be_an_error_for_less_than_100_ms(charger, active):
    charger.surround(supply_voltage=17.0)
    charger.step(0.1)
    charger.surround(supply_voltage=24.0)
    charger.step(0.2)
    charger.surround(supply_voltage=17.0)
    charger.step(0.1)
    assert active(charger) == [("WARNING", "supply_low")]
    charger.step(0.01)
    assert active(charger) == [("WARNING", "supply_low"), ("ERROR", "supply_low")]


@pytest.mark.parametrize(("sensor", "warning", "error"), THRESHOLDS)
def test_heat_warns_and_then_switches_off(make, active, sensor, warning, error):
    charger = make(PCSC, Variant.A)
    key = f"temp_{sensor}"
    told = []
    for temperature in (warning - 1, warning, error - 1, error):
        charger.surround(heat={sensor: temperature - 25.0})
        charger.step(0.01)
        told.append([kind for kind, told_key in active(charger) if told_key == key])
    assert told == [[], ["WARNING"], ["WARNING"], ["WARNING", "ERROR"]]


def test_without_a_discharging_stage_nothing_tells_its_temperature(charger, active):
    charger.surround(heat={"discharging": 100.0})
    charger.step(1.0)
    assert active(charger) == []


def test_a_short_is_an_error_after_a_second(running, active):
    running.surround(electrode=SHORT)
    running.step(1.0)
    assert running.charging_active
    running.step(0.1)
    assert ("ERROR", "output_short") in active(running)
    assert not running.charging_active


def test_drawing_more_than_the_supply_power_for_a_second_is_an_error(make, switch_on, active):
    charger = make(replace(PCSC, supply_power=54.0), voltage_setpoint=20000)
    switch_on(charger, 1.4)
    assert active(charger) == []
    charger.step(0.2)
    assert active(charger) == [("ERROR", "supply_current")]


@pytest.mark.parametrize(("voltage", "told"), [(33000.0, []), (33001.0, ["output_overvoltage"])])
def test_ten_percent_above_the_highest_voltage_are_an_error(charger, voltage, told):
    charger.messages.judge(charger.now, charger.situation._replace(voltage=voltage))
    assert [message.key for message in charger.messages.active] == told
