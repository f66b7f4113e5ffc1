import pytest

from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import ReleaseSource
from canopen_twins.devices.charger.model.sparks import Counter, Storm


def counts(charger):
    return [charger.charging.sparks.counts[counter] for counter in Counter]


def test_a_storm_strikes_about_as_often_as_it_says(running):
    running.write(Parameter.SPARKS_LIMIT, 0)
    running.surround(storm=Storm(rate=2.0, seed=1))
    running.step(300.0)
    too_small = (0.20 - 0.15) / (0.5 - 0.15)  # below the lowest level
    assert sum(counts(running)) == pytest.approx(600 * (1 - too_small), rel=0.15)
    assert all(counts(running))


def test_a_storm_is_the_same_for_the_same_seed_and_another_for_another(make, switch_on):
    def storm(seed):
        charger = make(voltage_setpoint=20000, sparks_limit=0)
        switch_on(charger)
        charger.surround(storm=Storm(rate=1.0, seed=seed))
        charger.step(40.0)
        return counts(charger)

    assert storm(1) == storm(1)
    assert storm(1) != storm(2)


def test_a_storm_may_depend_on_the_voltage(running):
    running.write(Parameter.SPARKS_LIMIT, 0)
    running.surround(storm=Storm(rate=2.0, breakdown=30000.0, scale=1000.0))
    running.step(600.0)
    assert counts(running) == [0, 0, 0, 0]


def test_a_storm_ends_when_it_is_called_off_and_pauses_without_voltage(running):
    running.write(Parameter.SPARKS_LIMIT, 0)
    running.surround(storm=Storm(rate=5.0))
    running.revoke(ReleaseSource.CANOPEN)
    running.step(60.0)
    assert counts(running) == [0, 0, 0, 0]
    running.grant(ReleaseSource.CANOPEN)
    running.step(60.0)
    counted = counts(running)
    assert sum(counted) > 50
    running.surround(storm=None)
    running.step(60.0)
    assert counts(running) == counted
