import pytest

CV = (2000, 4000, 4000, 0)

# cause, error number, seconds it has to last
CAUSES = [
    ({"supplies": {"24V": 21.5}}, 0x4B, 0.001),
    ({"supplies": {"24V": 26.5}}, 0x4C, 0.001),
    ({"supplies": {"24V": 22.0}}, None, 1.0),
    ({"supplies": {"5V": 4.4}}, 0x43, 0.001),
    ({"supplies": {"5V": 5.6}}, 0x44, 0.001),
    ({"supplies": {"15V": 13.4}}, 0x45, 0.001),
    ({"supplies": {"15V": 16.6}}, 0x46, 0.001),
    ({"supplies": {"-15V": -13.4}}, 0x47, 0.001),
    ({"supplies": {"-15V": -16.6}}, 0x48, 0.001),
    ({"interlock_closed": False}, 0xF2, 0.001),
    ({"sense_offset": 21.0}, 0x31, 0.001),
    ({"sense_offset": -21.0}, 0x31, 0.001),
    ({"sense_offset": 19.0}, None, 1.0),
    ({"sense_reversed": True}, 0x33, 0.001),
    ({"slave_silent": True}, None, 1.0),  # a single unit has none
    ({"mains_frequency": 40.0}, None, 1.0),  # a rectifier does not care
]


def assign(stage, values):
    for name, value in values.items():
        setattr(stage, name, value)


@pytest.mark.spec("T-193", "A-63")
@pytest.mark.parametrize(("cause", "error", "delay"), CAUSES)
def test_a_cause_trips_the_output_once_it_has_lasted(running, cause, error, delay):
    stage = running(parts=CV)
    assign(stage, cause)
    stage.step(delay - 0.001)
    assert stage.errors == ()
    assert stage.running
    stage.step(0.001)
    assert stage.errors == ((error,) if error else ())
    assert stage.running is (error is None)


@pytest.mark.spec("T-193")
@pytest.mark.parametrize(
    ("steps", "error"),
    [((370, 339.9), 0x49), ((430, 460.1), 0x4A), ((370, 340.1), None), ((430, 459.9), None)],
)
def test_mains_out_of_range_are_seen_on_the_dc_link(running, steps, error):
    stage = running(parts=CV)
    for mains in steps:
        stage.mains = mains
        stage.step(0.001)
    stage.step(0.018)
    assert stage.errors == ()
    stage.step(0.001)
    assert stage.errors == ((error,) if error else ())


@pytest.mark.spec("T-193")
@pytest.mark.parametrize(
    ("cause", "error"),
    [
        ({"mains": 339.0}, 0x145),
        ({"mains": 500.0}, 0x144),
        ({"mains_frequency": 47.9}, 0x143),
        ({"mains_frequency": 62.1}, 0x142),
    ],
)
def test_a_regenerating_unit_names_the_mains_not_the_dc_link(running, cause, error):
    stage = running(parts=CV, figures={"regenerative": True})
    assign(stage, cause)
    stage.step(0.019)
    assert stage.errors == ()
    stage.step(0.001)
    assert stage.errors == (error,)


def test_a_stage_does_not_rest_while_a_delay_runs(running):
    stage = running(parts=CV, mains=380.0)
    assert stage.rest > 0
    stage.mains = 339.0
    stage.step(0.001)
    assert stage.rest == 0.0
    stage.step(0.019)
    assert stage.errors == (0x49,)


def test_a_dip_shorter_than_the_delay_is_ridden_through(running):
    stage = running(parts=CV, mains=380.0)
    for _ in range(5):
        stage.mains = 339.0
        stage.step(0.019)
        stage.mains = 380.0
        stage.step(0.001)
    assert stage.errors == ()


@pytest.mark.parametrize(("mains", "tripped"), [(342.0, False), (458.0, False), (470.0, True)])
def test_mains_that_jump_are_a_transient_on_the_dc_link(running, mains, tripped):
    stage = running(parts=CV)
    stage.mains = mains
    stage.step(0.001)
    assert (0x4D in stage.errors) is tripped
    stage.step(1.0)
    assert stage.errors == ((0x4D, 0x4A) if tripped else ())


def test_mains_that_slide_are_no_transient(running):
    stage = running(parts=CV)
    for mains in range(400, 340, -5):
        stage.mains = mains
        stage.step(0.001)
    for mains in range(345, 460, 5):
        stage.mains = mains
        stage.step(0.001)
    assert stage.errors == ()
