import pytest

from canopen_twins.devices.gateway.model.engine import Engine
from canopen_twins.devices.gateway.model.speed_governor import NEXT, Mode

CYCLE = 0.015625


class Genset:
    """An engine under its governor, looked at once per main cycle."""

    def __init__(self, rig):
        self.rig = rig().on()
        self.engine, self.operation = self.rig.governor.engine, self.rig.governor.operation

    def speeds(self, seconds):
        """Speed at the end of every main cycle."""
        values = []
        for _ in range(round(seconds / CYCLE)):
            self.rig.run(CYCLE)
            values.append(self.engine.speed)
        return values

    def read(self, number):
        return self.rig.governor.desk.read(number)


@pytest.fixture
def standing(plain):
    """A genset that is not started yet."""

    def build():
        rig = plain()
        rig.governor.operation.run = rig.governor.operation.autostart = False
        return rig

    genset = Genset(build)
    genset.operation.local_setpoint = 700
    return genset


@pytest.fixture
def running(standing):
    standing.operation.run = True
    standing.operation.local_setpoint = 1500
    standing.speeds(20)
    return standing


def recovery(speeds):
    """Seconds until the speed stays within one per cent."""
    outside = [place for place, speed in enumerate(speeds) if abs(speed - 1500) > 15]
    return (outside[-1] + 1) * CYCLE


def test_start(standing):
    standing.operation.run = True
    speeds = standing.speeds(10)
    released = next(place for place, speed in enumerate(speeds) if speed >= 400)
    assert released * CYCLE == pytest.approx(0.72, abs=0.02)
    assert max(speeds) == pytest.approx(752, abs=0.5)
    assert speeds[-1] == pytest.approx(700.0, abs=0.05)
    assert standing.read(2300) == pytest.approx(5.4, abs=0.05)


def test_ramp_to_rated_speed(standing):
    standing.operation.run = True
    standing.speeds(10)
    standing.operation.local_setpoint = 1500
    setpoints = []
    speeds = standing.speeds(1)
    setpoints.append(standing.read(2031))
    assert setpoints[0] == pytest.approx(900, abs=5)
    speeds = standing.speeds(15)
    assert max(speeds) - 1500 == pytest.approx(20.1, abs=0.1)
    assert speeds[-1] == pytest.approx(1500, abs=0.1)


def test_load_steps(running):
    for load, dip, time in [(100e3, -4.73, 1.22), (200e3, -4.97, 1.19)]:
        running.engine.load = load
        speeds = running.speeds(10)
        assert (min(speeds) / 1500 - 1) * 100 == pytest.approx(dip, abs=0.05)
        assert recovery(speeds) == pytest.approx(time, abs=0.03)
    assert running.read(2300) == pytest.approx(78.4, abs=0.1)
    assert running.read(2908) == pytest.approx(57.6, abs=0.1)
    assert running.read(2917) == 100
    running.engine.load = 0.0
    speeds = running.speeds(10)
    assert (max(speeds) / 1500 - 1) * 100 == pytest.approx(12.9, abs=0.05)
    assert recovery(speeds) == pytest.approx(1.78, abs=0.03)
    assert running.read(3004) == 0


@pytest.mark.parametrize(("load", "speed"), [(200e3, 1440.0), (100e3, 1470.0)])
def test_droop(running, load, speed):
    running.operation.droop = 0.04
    running.engine.load = load
    assert running.speeds(20)[-1] == pytest.approx(speed, abs=0.1)


def test_stop(running):
    running.operation.run = False
    speeds = running.speeds(20)
    standstill = next(place for place, speed in enumerate(speeds) if speed < 10)
    assert standstill * CYCLE == pytest.approx(15.9, abs=0.1)
    assert running.rig.governor.programme.control.speed.mode is Mode.STOPPED
    assert speeds[-1] == 0


def test_oil_pressure_follows_the_speed(running):
    assert running.read(2905) == pytest.approx(4.5, abs=0.01)
    running.operation.run = False
    running.speeds(30)
    assert running.read(2905) == pytest.approx(0, abs=0.01)


def test_overspeed_stops_the_engine_until_the_errors_are_cleared(running):
    running.engine.speed = 2071
    running.speeds(0.1)
    assert running.read(3004) == 1
    assert running.read(2330) == 0
    present = running.rig.governor.memory.present
    states = running.rig.governor.programme.control.states(present)
    assert states["overspeed stop"]
    assert states["running down"]
    running.speeds(25)
    assert running.engine.speed == 0
    running.rig.governor.desk.clear_errors()
    running.speeds(10)
    assert (running.read(3004), running.read(3104)) == (0, 1)
    assert running.engine.speed == 0
    running.operation.run = False
    running.speeds(0.1)
    running.operation.run = True
    running.speeds(10)
    assert running.engine.speed > 700


def test_a_governor_reset_takes_the_fuel_away_and_the_engine_over(running):
    running.rig.governor.reset()
    running.rig.run(0.201)
    assert 1400 < running.engine.speed < 1500
    assert running.read(2031) > 1400
    speeds = running.speeds(10)
    assert min(speeds) > 1400
    assert speeds[-1] == pytest.approx(1500, abs=1)


@pytest.mark.parametrize("mode", Mode)
def test_every_mode_can_be_left(mode):
    assert set(NEXT[mode].values()) - {mode}


def test_an_engine_at_rest_does_not_mind_how_time_passes():
    lone, other = Engine(), Engine()
    for engine in (lone, other):
        engine.speed, engine.charge_air = 300.0, 60.0
    for second in range(1, 101):
        lone.run_to(second * 1_000_000)
    other.run_to(100_000_000)
    assert (lone.speed, other.speed) == (0, 0)
    assert lone.charge_air == pytest.approx(other.charge_air)


def test_a_day_without_the_governor_passes_at_once():
    engine = Engine()
    engine.speed = 1500.0
    engine.run_to(86_400_000_000)
    assert engine.speed == 0
