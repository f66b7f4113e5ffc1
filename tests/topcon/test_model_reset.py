import pytest

from canopen_twins.devices.topcon.model.states import StageState

CV = (2000, 4000, 4000, 0)


@pytest.mark.spec("T-176", "A-48")
def test_a_reset_leads_to_ready_and_starts_nothing(running):
    stage = running(parts=CV)
    stage.trip(0x23)
    assert stage.state is StageState.ERROR
    stage.reset()
    stage.step(1.0)
    assert stage.errors == ()
    assert stage.state is StageState.READY
    stage.run()
    assert stage.running


@pytest.mark.spec("A-47")
@pytest.mark.parametrize("command", ["run", "stop"])
def test_in_error_nothing_but_reset_has_an_effect(running, command):
    stage = running(parts=CV)
    stage.trip(0x23)
    assert stage.blocked
    getattr(stage, command)()
    assert stage.state is StageState.ERROR
    assert stage.errors == (0x23,)


@pytest.mark.spec("A-60")
def test_an_error_stays_when_its_cause_goes(running):
    stage = running(parts=CV)
    stage.mains = 300.0
    stage.step(0.1)
    stage.mains = 400.0
    stage.step(1.0)
    assert 0x49 in stage.errors
    stage.reset()
    assert stage.errors == ()


@pytest.mark.spec("A-49", "A-61")
def test_a_reset_removes_the_errors_without_a_cause_and_keeps_the_others(running):
    stage = running(parts=CV)
    stage.trip(0x23)
    stage.supplies = {"24V": 20.0}
    stage.step(0.001)
    stage.trip(0x24)
    assert stage.errors == (0x23, 0x4B, 0x24)
    stage.reset()
    assert stage.errors == (0x4B,)
    assert stage.state is StageState.ERROR
    stage.supplies = {}
    stage.reset()
    assert stage.state is StageState.READY


def test_a_held_error_outlives_resets_until_it_is_released(running):
    stage = running(parts=CV)
    stage.trip(0xF4, held=True)
    stage.trip(0xF4, held=True)  # the same cause, not a second one
    stage.reset()
    assert stage.errors == (0xF4,)
    stage.release(0xF4)
    assert stage.errors == (0xF4,)
    stage.reset()
    assert stage.errors == ()
    stage.release(0xF4)  # nothing left to release: no harm


@pytest.mark.spec("T-051")
def test_an_error_raised_twice_is_there_once(running):
    stage = running(parts=CV)
    stage.trip(0x23)
    stage.trip(0x23)
    assert stage.errors == (0x23,)


@pytest.mark.spec("A-62")
@pytest.mark.parametrize("error", [-1, 0x200])
def test_an_error_number_has_nine_bits(power_on, error):
    with pytest.raises(ValueError, match="0x1ff"):
        power_on().trip(error)


@pytest.mark.spec("T-193")
def test_an_open_interlock_blocks_run_and_reset(power_on):
    stage = power_on(parts=CV)
    stage.interlock_closed = False
    assert stage.blocked
    stage.run()
    assert stage.state is StageState.READY
    stage.step(0.001)
    stage.reset()
    assert stage.errors == (0xF2,)
    stage.interlock_closed = True
    stage.reset()
    stage.run()
    assert stage.running


@pytest.mark.parametrize("overvoltage_when_off", [True, False])
def test_an_overvoltage_cannot_be_reset_before_the_capacitor_is_below_the_level(
    running, overvoltage_when_off
):
    stage = running(parts=CV, overvoltage_when_off=overvoltage_when_off)
    stage.overvoltage_level = 100.0
    stage.step(0.6)  # the bleeder needs 0.69 s to halve the voltage
    stage.reset()
    assert stage.errors == (0x30,)
    stage.step(0.1)
    stage.reset()
    assert stage.errors == ()


def test_an_overcurrent_can_be_reset_as_soon_as_the_output_is_off(running):
    stage = running(load="inductor 1 10", parts=CV)
    stage.overcurrent_level = 10.0
    stage.step(0.005)
    assert stage.errors == (0x21,)
    assert stage.current > 10.0  # the winding carries on
    stage.reset()
    assert stage.errors == ()


def test_an_i2t_trip_can_be_reset_once_the_store_is_below_its_limit(running):
    limits = {"i2t_current": 50.0, "i2t_limit": 1000.0}
    stage = running(load="resistor 4", parts=(4000, 4000, 4000, 0), figures=limits)
    assert stage.errors == (0x20,)
    stage.reset()
    assert stage.errors == ()
    assert stage.store.charge == 0.0


@pytest.mark.spec("A-49")
def test_a_reset_without_an_error_leaves_the_output_on(running):
    stage = running(parts=CV)
    stage.reset()
    assert stage.state is StageState.RUN
    assert stage.rest > 0


HOT_LOAD = {"load": "resistor 20", "parts": (4000, 4000, 4000, 0), "figures": {"efficiency": 0.6}}


@pytest.mark.spec("T-193", "A-89")
@pytest.mark.parametrize(("kelvin", "until"), [(10.0, 85.0), (25.0, 70.0), (0.0, 95.0)])
def test_an_overtemperature_is_over_once_the_heat_sink_has_cooled_down(running, kelvin, until):
    stage = running(**HOT_LOAD, cooldown=kelvin)
    while not stage.errors:
        stage.step(0.01)
    assert stage.errors == (0x51,)
    stage.step(0.01)
    while stage.temperature > until + 0.01:
        stage.reset()
        stage.run()
        assert (stage.errors, stage.running) == ((0x51,), False)
        stage.step(0.1)
    stage.step(0.2)
    stage.reset()
    assert stage.errors == ()
    stage.run()
    assert stage.running
