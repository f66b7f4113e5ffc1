import pytest

FULL = (4000, 4000, 4000, 0)
CV = (2000, 4000, 4000, 0)


def readings(stage):
    return stage.voltage, stage.current, stage.power, stage.temperature, stage.store.charge


def test_what_is_less_than_a_tick_waits_for_the_next_step(power_on):
    stage = power_on(load="resistor 10", parts=FULL)
    stage.run()
    for _ in range(125):
        stage.step(0.0004)
    assert stage.ticks == 50
    assert stage.ramps.voltage == pytest.approx(200)


def test_every_whole_millisecond_is_a_tick(power_on):
    stage = power_on()
    for milliseconds in range(1, 3000):
        before = stage.ticks
        stage.step(milliseconds / 1000)
        assert stage.ticks - before == milliseconds


def test_no_step_moves_nothing(power_on):
    stage = power_on(parts=FULL)
    stage.run()
    stage.step(0.0)
    assert stage.ticks == 0


def test_one_big_step_through_a_transient_is_its_ticks_one_by_one(power_on):
    big, small = (power_on(load="resistor 5", parts=CV) for _ in range(2))
    for stage in (big, small):
        stage.overcurrent_level = 30.0
        stage.run()
    big.step(0.05)
    for _ in range(50):
        small.step(0.001)
    assert readings(big) == readings(small)
    assert big.errors == small.errors == (0x21,)
