import pytest

from canopen_twins.devices.charger.model.messages import Kind
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import Source, State


@pytest.mark.spec("C-143")
def test_an_error_switches_off_and_blocks_until_it_is_cleared(running, catalogue):
    error = catalogue.keyed(Kind.ERROR, "hardware")
    running.force(error)
    assert running.release.state is State.FAULT
    running.grant(Source.CANOPEN)
    assert not running.release.software
    running.unforce(error)
    running.clear(Kind.ERROR, error.number)
    assert running.release.state is State.LOCKED
    running.grant(Source.CANOPEN)
    assert running.charging_active


@pytest.mark.spec("C-143")
def test_one_of_two_errors_goes_on_blocking(charger, catalogue):
    errors = [catalogue.keyed(Kind.ERROR, key) for key in ("hardware", "parameter_memory")]
    for error in errors:
        charger.force(error)
        charger.unforce(error)
    charger.clear(Kind.ERROR, errors[0].number)
    assert charger.release.state is State.FAULT
    charger.clear(Kind.ERROR, errors[1].number)
    assert charger.release.state is State.LOCKED


@pytest.mark.spec("C-143")
def test_autostart_does_not_come_back_by_itself_after_an_error(make, catalogue):
    charger = make(release_mode=Source.AUTOSTART.value)
    error = catalogue.keyed(Kind.ERROR, "hardware")
    charger.force(error)
    charger.unforce(error)
    charger.clear(Kind.ERROR, error.number)
    charger.step(1.0)
    assert charger.release.state is State.LOCKED


@pytest.mark.spec("C-143")
def test_a_warning_neither_switches_off_nor_blocks(running, catalogue):
    running.force(catalogue.keyed(Kind.WARNING, "temp_inside"))
    assert running.charging_active
    running.revoke(Source.CANOPEN)
    running.grant(Source.CANOPEN)
    assert running.charging_active


def test_a_restart_takes_the_release_and_the_messages_away(running, catalogue, active):
    error = catalogue.keyed(Kind.ERROR, "hardware")
    running.force(error)
    running.unforce(error)
    running.restart({Parameter.RELEASE_MODE: Source.CANOPEN.value})
    assert running.release.state is State.LOCKED
    assert active(running) == []


def test_an_error_that_persists_over_a_restart_keeps_autostart_off(make, catalogue, active):
    charger = make()
    charger.force(catalogue.keyed(Kind.ERROR, "hardware"))
    charger.restart({Parameter.RELEASE_MODE: Source.AUTOSTART.value})
    assert active(charger) == [("ERROR", "hardware")]
    assert not charger.charging_active
