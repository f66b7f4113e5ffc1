import pytest

from canopen_twins.devices.charger.model.charger import Charger
from canopen_twins.devices.charger.model.messages import CAUSES, Catalogue, Message, Severity
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import ReleaseSource
from canopen_twins.devices.charger.model.types import PCSC, Build


def clear(charger, key):
    message = next(message for message in charger.messages.active if message.key == key)
    charger.clear(message.severity, message.number)


@pytest.mark.spec("C-045")
def test_heat_may_be_cleared_3_k_below_its_threshold(charger, active):
    charger.surround(heat={"cascade": 50.0})
    charger.step(0.01)
    for heat, left in ((42.5, [("WARNING", "temp_cascade")]), (41.5, [])):
        charger.surround(heat={"cascade": heat})
        charger.step(0.01)
        clear(charger, "temp_cascade")
        assert active(charger) == left


@pytest.mark.spec("C-045")
def test_a_message_whose_cause_persists_is_not_cleared(charger, active):
    charger.surround(supply_voltage=19.0)
    charger.step(0.01)
    clear(charger, "supply_low")
    assert active(charger) == [("WARNING", "supply_low")]
    charger.surround(supply_voltage=24.0)
    clear(charger, "supply_low")
    assert active(charger) == []


@pytest.mark.spec("C-045")
def test_clearing_what_is_not_active_does_nothing(charger, active):
    charger.surround(supply_voltage=19.0)
    charger.step(0.01)
    charger.surround(supply_voltage=24.0)
    charger.clear(Severity.WARNING, 2)
    charger.clear(Severity.ERROR, 1)
    assert active(charger) == [("WARNING", "supply_low")]


@pytest.mark.spec("C-045")
def test_an_injected_message_is_cleared_once_its_cause_is_withdrawn(charger, active):
    message = Message(Severity.ERROR, 0x50, 0xFF00, 0x81)
    charger.force(message)
    charger.clear(Severity.ERROR, 0x50)
    assert charger.messages.active == [message]
    charger.unforce(message)
    assert charger.messages.active == [message]
    charger.clear(Severity.ERROR, 0x50)
    assert charger.messages.active == []


@pytest.mark.spec("C-035")
def test_a_message_appears_once_however_long_its_cause_lasts(charger, active):
    charger.surround(supply_voltage=19.0)
    charger.step(600.0)
    assert active(charger) == [("WARNING", "supply_low")]


def test_messages_stand_in_the_order_in_which_they_came(charger, catalogue, active):
    charger.force(catalogue.keyed(Severity.WARNING, "temp_inside"))
    charger.surround(supply_voltage=31.0)
    charger.step(0.01)
    charger.force(catalogue.keyed(Severity.WARNING, "temp_cascade"))
    keys = [key for _, key in active(charger)]
    assert keys == ["temp_inside", "supply_high", "temp_cascade"]


def test_an_error_that_does_not_trip_switches_nothing_off(running, active):
    running.force(Message(Severity.ERROR, 0x40, 0xFF00, 0x81, trips=False))
    assert running.charging_active
    assert running.messages.has(Severity.ERROR)
    assert not running.messages.has(Severity.WARNING)


def test_what_the_catalogue_leaves_out_is_not_reported(charger):
    catalogue = Catalogue([])
    values = {name: charger.parameters[name] for name in Parameter}
    silent = Charger(Build(PCSC), values, catalogue)
    silent.surround(supply_voltage=10.0)
    silent.step(10.0)
    assert silent.messages.active == []
    assert silent.messages.unreported == [(cause.severity, cause.key) for cause in CAUSES]
    silent.grant(ReleaseSource.CANOPEN)
    assert silent.charging_active
