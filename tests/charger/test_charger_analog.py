import pytest

from canopen_twins.devices.charger.model.parameters import Parameter


@pytest.mark.spec("C-166")
@pytest.mark.parametrize("interface", range(6))
def test_the_analog_setpoint_replaces_that_of_the_bus_where_it_is_active(
    make, switch_on, interface
):
    charger = make(analog_setpoint=interface, voltage_setpoint=10000)
    charger.surround(analog=50.0)
    switch_on(charger)
    active = interface in (1, 2, 4, 5)
    assert charger.charging.output.voltage == (15000 if active else 10000)
    assert charger.parameters[Parameter.VOLTAGE_SETPOINT] == 10000
