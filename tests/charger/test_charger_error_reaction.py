import pytest

from canopen_twins.devices.charger.model.messages import Severity
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import ReleaseSource, ReleaseState


@pytest.mark.spec("C-143")
def test_an_error_switches_off_and_blocks_until_it_is_cleared(running, catalogue):
    error = catalogue.keyed(Severity.ERROR, "hardware")
    running.force(error)
    assert running.release.state is ReleaseState.FAULT
    running.grant(ReleaseSource.CANOPEN)
    assert not running.release.software
    running.unforce(error)
    running.clear(Severity.ERROR, error.number)
    assert running.release.state is ReleaseState.LOCKED
    running.grant(ReleaseSource.CANOPEN)
    assert running.charging_active


@pytest.mark.spec("C-143")
def test_one_of_two_errors_goes_on_blocking(charger, catalogue):
    errors = [catalogue.keyed(Severity.ERROR, key) for key in ("hardware", "parameter_memory")]
    for error in errors:
        charger.force(error)
        charger.unforce(error)
    charger.clear(Severity.ERROR, errors[0].number)
    assert charger.release.state is ReleaseState.FAULT
    charger.clear(Severity.ERROR, errors[1].number)
    assert charger.release.state is ReleaseState.LOCKED


@pytest.mark.spec("C-143")
def test_autostart_does_not_come_back_by_itself_after_an_error(make, catalogue):
    charger = make(release_mode=ReleaseSource.AUTOSTART.value)
    error = catalogue.keyed(Severity.ERROR, "hardware")
    charger.force(error)
    charger.unforce(error)
    charger.clear(Severity.ERROR, error.number)
    charger.step(1.0)
    assert charger.release.state is ReleaseState.LOCKED


@pytest.mark.spec("C-143")
def test_a_warning_neither_switches_off_nor_blocks(running, catalogue):
    running.force(catalogue.keyed(Severity.WARNING, "temp_inside"))
    assert running.charging_active
    running.revoke(ReleaseSource.CANOPEN)
    running.grant(ReleaseSource.CANOPEN)
    assert running.charging_active


def test_a_restart_takes_the_release_and_the_messages_away(running, catalogue, active):
    error = catalogue.keyed(Severity.ERROR, "hardware")
    running.force(error)
    running.unforce(error)
    running.restart({Parameter.RELEASE_MODE: ReleaseSource.CANOPEN.value})
    assert running.release.state is ReleaseState.LOCKED
    assert active(running) == []


def test_an_error_that_persists_over_a_restart_keeps_autostart_off(make, catalogue, active):
    charger = make()
    charger.force(catalogue.keyed(Severity.ERROR, "hardware"))
    charger.restart({Parameter.RELEASE_MODE: ReleaseSource.AUTOSTART.value})
    assert active(charger) == [("ERROR", "hardware")]
    assert not charger.charging_active
