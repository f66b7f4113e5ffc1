from math import inf, log

import pytest

from canopen_twins.devices.topcon.model.thermal import HeatSink, I2tStore

FULL = (4000, 4000, 4000, 0)


def test_rest_is_the_time_to_the_temperature_warning(running):
    stage = running(load="resistor 5", parts=FULL, ambient=45.0)
    end, tau = 45 + stage.loss * 0.0166, 0.0166 * 6000
    expected = tau * log((end - stage.temperature) / (end - 80))
    assert stage.rest == pytest.approx(expected)
    stage.step(stage.rest - 0.001)
    assert not stage.warning
    stage.step(0.002)
    assert stage.warning
    assert stage.temperature == pytest.approx(80.0, abs=0.001)


def test_after_the_warning_rest_is_the_time_until_derating_is_felt(running):
    stage = running(load="resistor 5", parts=FULL, ambient=45.0)
    stage.step(stage.rest + 0.001)
    assert stage.rest > 1.0
    stage.step(stage.rest + 0.001)
    assert stage.temperature == pytest.approx(86.0, abs=0.05)  # 80 A of 100 A are left
    assert stage.rest == pytest.approx(0.01)


def test_rest_is_the_time_to_the_temperature_trip(running):
    stage = running(load="resistor 20", parts=FULL, figures={"efficiency": 0.6})
    assert stage.current == pytest.approx(
        20, rel=1e-4
    )  # never derated: half of 100 A remains at 95 degrees
    stage.step(stage.rest + 0.001)
    assert stage.warning
    assert stage.running
    stage.step(stage.rest - 0.002)
    assert stage.running
    stage.step(0.003)
    assert stage.errors == (0x51,)
    assert stage.temperature == pytest.approx(95.0, abs=0.01)


@pytest.mark.spec("T-192")
def test_rest_is_the_time_to_the_i2t_warning_and_trip(running):
    limits = {"i2t_current": 50.0, "i2t_limit": 1e6}
    stage = running(load="resistor 4", parts=FULL, figures=limits)
    rate = stage.current**2 - 50**2
    assert stage.rest == pytest.approx((0.5e6 - stage.store.charge) / rate)
    stage.step(stage.rest + 0.001)
    assert stage.warning
    assert stage.rest == pytest.approx((1e6 - stage.store.charge) / rate)
    stage.step(stage.rest + 0.001)
    assert stage.errors == (0x20,)


@pytest.mark.parametrize(
    ("temperature", "part"), [(-20, 1.0), (80, 1.0), (86, 0.8), (92, 0.6), (95, 0.5), (200, 0.5)]
)
def test_the_maximum_current_falls_to_half_between_80_and_95_degrees(units, temperature, part):
    assert HeatSink(units["TCP-32-400"], temperature).derating == pytest.approx(part)


def test_the_heat_sink_follows_its_time_constant_in_steps_of_any_length(units):
    one, many = (HeatSink(units["TCP-32-400"], 25.0) for _ in range(2))
    one.step(one.time_constant, loss=1000.0, ambient=25.0)
    for _ in range(1000):
        many.step(many.time_constant / 1000, loss=1000.0, ambient=25.0)
    assert one.temperature == pytest.approx(25 + 16.6 * 0.632121, rel=1e-6)
    assert many.temperature == pytest.approx(one.temperature, rel=1e-12)


def test_the_permitted_current_fills_no_i2t_store_not_even_by_its_last_bit(units):
    store = I2tStore(units["TCP-32-400"])
    assert store.time_to(5000.0, 100.0 * (1 + 1e-12)) == inf
    assert store.time_to(5000.0, 110.0) == pytest.approx(5000 / (110**2 - 100**2))
