from math import log

import pytest

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
    assert stage.rest == pytest.approx((0.5e6 - stage.i2t) / rate)
    stage.step(stage.rest + 0.001)
    assert stage.warning
    assert stage.rest == pytest.approx((1e6 - stage.i2t) / rate)
    stage.step(stage.rest + 0.001)
    assert stage.errors == (0x20,)
