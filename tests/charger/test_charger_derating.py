import pytest


@pytest.mark.spec("C-152")
@pytest.mark.parametrize(
    ("heat", "supply", "watts"),
    [(0.0, 24.0, 100.0), (0.0, 19.6, 50.0), (0.0, 18.0, 0.0), (100.0, 24.0, 0.0)],
)
def test_heat_and_a_poor_supply_lower_the_power_setpoint(charger, heat, supply, watts):
    charger.surround(supply_voltage=supply, heat={"power_stage": heat})
    charger.step(1.0)
    assert charger.derating.charging == pytest.approx(watts, abs=4)


@pytest.mark.spec("C-152")
def test_the_power_setpoint_falls_evenly_from_70_to_85_degrees(charger):
    warm = charger.heating.at(charger.now)["power_stage"]
    charger.surround(heat={"power_stage": 77.5 - warm})
    charger.step(1.0)
    assert charger.derating.charging == pytest.approx(50.0, abs=0.5)


@pytest.mark.spec("C-152")
def test_the_power_setpoint_follows_at_once(charger):
    charger.step(0.5)
    charger.surround(supply_voltage=19.6)
    assert charger.derating.charging < 60
    charger.surround(supply_voltage=24.0)
    assert charger.derating.charging == 100
    charger.surround(heat={"power_stage": 100.0})
    assert charger.derating.charging == 0
