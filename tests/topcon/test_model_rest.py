from math import inf

import pytest

from canopen_twins.devices.topcon.model.loads import Short
from canopen_twins.devices.topcon.model.stage import OutputStage
from canopen_twins.devices.topcon.model.states import StageState

FULL = (4000, 4000, 4000, 0)
CV = (2000, 4000, 4000, 0)

SETTLED = {
    "off": ("open", (0, 0, 4000, 0)),
    "open": ("open", CV),
    "resistor in CV": ("resistor 10", CV),
    "resistor in CC": ("resistor 4", (4000, 2000, 4000, 0)),
    "resistor in CP": ("resistor 4", FULL),
    "short": ("short", (4000, 1000, 4000, 0)),
    "battery": ("battery 350 0.1", (3000, 800, 4000, 0)),
    "sink": ("sink 30", (2000, 1000, 4000, 0)),
    "power": ("power 5000", CV),
    "winding": ("inductor 2 0.01", (400, 4000, 4000, 0)),
    "full power": ("resistor 5", FULL),
}
PLACES = pytest.mark.parametrize(("load", "parts"), SETTLED.values(), ids=SETTLED)


class Counting(OutputStage):
    moves = 0

    def coast(self, ticks):
        self.moves += 1
        super().coast(ticks)


def readings(stage):
    return stage.voltage, stage.current, stage.power, stage.temperature, stage.store.charge


@PLACES
def test_a_settled_stage_takes_one_big_step_as_many_small_ones(running, load, parts):
    big, small = (running(load=load, parts=parts) for _ in range(2))
    big.step(5.0)
    for _ in range(5_000):
        small.step(0.001)
    assert readings(big) == pytest.approx(readings(small), rel=1e-9)
    assert (big.mode, big.warning, big.ticks) == (small.mode, small.warning, small.ticks)
    assert big.rest == pytest.approx(small.rest)


@PLACES
def test_an_hour_of_a_settled_stage_is_a_handful_of_steps(running, load, parts):
    stage = running(load=load, parts=parts, kind=Counting)
    stage.moves = 0
    drive(stage, 3600.0)
    assert stage.moves <= 3


def drive(stage, seconds):
    """As a node does it: sleep while the stage rests, step every millisecond while not."""
    end = stage.ticks + round(seconds / stage.tick)
    while (left := (end - stage.ticks) * stage.tick) > 0:
        stage.step(max(0.001, min(stage.rest, left)))


@pytest.mark.parametrize("load", ["open", "resistor 10", "inductor 2 0.1", "battery 350 0.1"])
def test_a_stage_comes_to_rest_after_stop_too(running, load):
    stage = running(load=load, parts=CV)
    stage.stop()
    assert stage.rest == 0.0
    stage.step(30.0)
    assert stage.rest == inf


def test_the_steady_state_is_reached_exactly(running):
    stage = running(parts=CV)
    assert stage.voltage == 200.0
    stage.stop()
    stage.step(30.0)
    assert stage.voltage == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("load", None),
        ("ambient", 30.0),
        ("mains", 390.0),
        ("supplies", {"24V": 23.0}),
        ("interlock_closed", False),
        ("voltage_reference", 150.0),
        ("current_reference", 50.0),
        ("power_reference", 100.0),
        ("resistance_reference", 1.0),
        ("overvoltage_level", 100.0),
        ("sense_reversed", True),
    ],
)
def test_an_assignment_wakes_a_resting_stage(running, name, value):
    stage = running(load="resistor 10", parts=CV)
    assert stage.rest == inf
    setattr(stage, name, value or running(load="resistor 5").load)
    assert stage.rest == 0.0


def test_a_stage_at_rest_answers_a_stop_at_its_next_step(running):
    stage = running(load="resistor 10", parts=CV)
    stage.step(100.0)
    stage.stop()
    stage.step(1.0)
    assert stage.voltage == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("cause", [{"interlock_closed": False}, {"overvoltage_level": 100.0}])
def test_a_stage_at_rest_answers_a_trip_at_its_next_step(running, cause):
    stage = running(load="resistor 10", parts=CV)
    for name, value in cause.items():
        setattr(stage, name, value)
    stage.step(1.0)
    assert stage.state is StageState.ERROR
    assert stage.voltage == pytest.approx(0.0, abs=1e-6)


def test_an_hour_in_one_step_ends_as_an_hour_driven_by_rest(running):
    one = running(load="resistor 5", parts=FULL, ambient=45.0)
    many = running(load="resistor 5", parts=FULL, ambient=45.0)
    one.step(3600.0)
    drive(many, 3600.0)
    assert readings(one) == pytest.approx(readings(many), rel=1e-6)
    assert one.warning
    assert one.errors == ()


def test_a_derated_stage_still_takes_a_change_of_load_tick_by_tick(running):
    stage = running(load="resistor 3", parts=FULL, ambient=88.0)
    assert stage.rest == pytest.approx(0.01)  # only heat moves it
    stage.load = Short()
    stage.step(0.001)
    assert stage.rest == 0.0
    stage.step(0.1)
    assert stage.rest == pytest.approx(0.01)


def test_a_current_that_hardly_moves_is_not_taken_for_settled(running):
    stage = running(load="inductor 1 1e7", parts=(1000, 4000, 4000, 0))
    stage.step(1.0)
    assert stage.current == pytest.approx(4e-5, rel=0.05)  # 100 V / 1e7 H, on its way to 100 A
    assert stage.rest == 0.0


def test_a_derated_stage_settles_where_heat_and_current_agree(running):
    stage = running(load="resistor 5", parts=FULL, ambient=70.0, kind=Counting)
    stage.step(3600.0)
    assert stage.rest == inf
    assert stage.current == pytest.approx(stage.derated_maximum, rel=1e-5)
    assert stage.temperature == pytest.approx(70 + stage.loss * 0.0166, abs=1e-3)
    assert stage.moves < 100_000
    stage.ambient = 25.0  # a door opened
    stage.step(3600.0)
    assert stage.current == pytest.approx(80, rel=1e-4)


@pytest.mark.spec("T-192")
@pytest.mark.parametrize("pace", [1, 7, 100])
def test_a_stage_looked_at_all_the_time_trips_when_one_left_alone_does(running, pace):
    limits = {"i2t_current": 50.0, "i2t_limit": 2e4}
    watched, alone = (running(load="resistor 4", parts=FULL, figures=limits) for _ in range(2))
    while not alone.errors:
        alone.step(max(alone.tick, alone.rest))
    while watched.ticks < alone.ticks - pace:
        watched.step(pace * watched.tick)
    assert watched.errors == ()
    watched.step(pace * watched.tick)
    assert watched.errors == alone.errors == (0x20,)
