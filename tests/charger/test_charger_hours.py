import pytest

from canopen_twins import Bench
from canopen_twins.devices.charger.model.release import ReleaseSource
from canopen_twins.devices.charger.model.ticks import MINUTE, Hours, duration
from canopen_twins.devices.charger.model.types import PCSC, Variant

HOUR = 60 * MINUTE
DAY = 24 * HOUR
YEAR = 365 * DAY


@pytest.mark.spec("C-184")
@pytest.mark.parametrize(
    ("ticks", "shown"),
    [
        (0, (0, 0, 0, 0)),
        (MINUTE - 1, (0, 0, 0, 0)),
        (MINUTE, (0, 0, 0, 1)),
        (HOUR - 1, (0, 0, 0, 59)),
        (HOUR, (0, 0, 1, 0)),
        (DAY - 1, (0, 0, 23, 59)),
        (DAY, (0, 1, 0, 0)),
        (YEAR - 1, (0, 364, 23, 59)),
        (YEAR, (1, 0, 0, 0)),
        (256 * YEAR, (255, 0, 0, 0)),
    ],
)
def test_carries(ticks, shown):
    assert duration(ticks) == shown


@pytest.mark.spec("C-185")
def test_each_counter_runs_with_its_own_stage(make):
    charger = make(PCSC, Variant.A, mode_discharging=1, software_release_discharging=0)
    charger.surround(hardware_release_discharging=False)
    charger.step(60.0)
    charger.grant(ReleaseSource.CANOPEN)
    charger.step(120.0)
    charger.surround(hardware_release_discharging=True)
    charger.step(240.0)
    assert charger.hours == Hours(7 * MINUTE, 6 * MINUTE, 4 * MINUTE)


@pytest.mark.spec("C-185")
def test_a_restart_leaves_them_alone(charger):
    charger.step(90.0)
    charger.restart({})
    charger.step(30.0)
    assert charger.hours.operating == 2 * MINUTE


@pytest.mark.spec("C-185")
def test_they_continue_a_former_life(charger):
    charger.hours = Hours(operating=YEAR - MINUTE)
    charger.step(60.0)
    assert duration(charger.hours.operating) == (1, 0, 0, 0)


@pytest.mark.spec("C-184", "C-185")
def test_a_charger_may_have_run_before_it_is_delivered():
    bench = Bench(
        "charger", variant="A", operating_hours=8785.5, charging_hours=25, discharging_hours=1
    )
    read = [bench.sdo[0x2000][sub].raw for sub in range(1, 13)]
    assert read == [1, 1, 1, 30, 0, 1, 1, 0, 0, 0, 1, 0]
    bench.run(60.0)
    bench.power_off()
    bench.power_on()
    assert bench.sdo[0x2000][4].raw == 31
