import pytest

from canopen_twins.devices.charger.model.sparks import Counter, Sparks, SparkValue
from canopen_twins.devices.charger.model.types import PCMT, PCSC

SE, SW, WE, WW = Counter


def counts(charger):
    return [charger.charging.sparks.counts[counter] for counter in Counter]


@pytest.mark.spec("C-170", "C-171", "C-172")
@pytest.mark.parametrize(
    ("kind", "levels"),
    [(PCSC, [0.25, 0.20, 0.15625, 0.125]), (PCMT, [0.125, 0.10, 0.078125, 0.0625])],
    ids=["PCSC", "PCMT"],
)
def test_levels_of_the_factory_settings(make, kind, levels):
    charging = make(kind).charging
    told = [
        charging.sparks.level(counter, charging.parameters, charging.maximum_current)
        for counter in Counter
    ]
    assert told == pytest.approx(levels)


@pytest.mark.spec("C-170", "C-171")
def test_levels_follow_their_factors(make):
    charging = make(strong_sparks=25, weak_sparks=10).charging
    levels = [
        charging.sparks.level(counter, charging.parameters, charging.maximum_current)
        for counter in (SE, WE)
    ]
    assert levels == pytest.approx([25 * 5000 / 800 / 1000, 10 * 5000 / 800 / 1000])


@pytest.mark.spec("C-170")
def test_the_value_of_the_formula_may_be_read_as_a_bare_number(make):
    charging = make(sparks=Sparks(value=SparkValue.NUMBER)).charging
    levels = [
        charging.sparks.level(counter, charging.parameters, charging.maximum_current)
        for counter in Counter
    ]
    assert levels == pytest.approx([25.0, 20.0, 15.625, 12.5])
