import pytest
from charger_bus import put, status

from canopen_twins import Bench
from canopen_twins.devices.charger.model.parameters import Parameter
from canopen_twins.devices.charger.model.release import Release, ReleaseSource

BUSES = [ReleaseSource.CANOPEN, ReleaseSource.ETHERNET]
OTHERS = [ReleaseSource.HMI, ReleaseSource.ANALOG, ReleaseSource.AUTOSTART]
SOURCES = [*BUSES, *OTHERS]


@pytest.mark.spec("C-139")
def test_a_release_by_a_bus_ends_after_its_timeout(charger):
    charger.write(Parameter.RELEASE_TIMEOUT, 500)
    charger.grant(ReleaseSource.CANOPEN)
    charger.step(0.49)
    assert charger.release.software
    charger.step(0.01)
    assert not charger.release.software


@pytest.mark.spec("C-139")
@pytest.mark.parametrize("again", ["grant", "write"])
def test_every_new_release_rewinds_the_timeout_and_so_does_a_new_timeout(charger, again):
    charger.write(Parameter.RELEASE_TIMEOUT, 500)
    charger.grant(ReleaseSource.CANOPEN)
    charger.step(0.4)
    if again == "grant":
        charger.grant(ReleaseSource.CANOPEN)
    else:
        charger.write(Parameter.RELEASE_TIMEOUT, 500)
    charger.step(0.49)
    assert charger.release.software
    charger.step(0.01)
    assert not charger.release.software


@pytest.mark.spec("C-139")
def test_no_timeout_no_end(charger):
    charger.grant(ReleaseSource.CANOPEN)
    charger.step(3600.0)
    assert charger.release.software


@pytest.mark.spec("C-139")
@pytest.mark.parametrize("source", SOURCES)
def test_the_timeout_ends_every_release(source):
    release = Release()
    release.set(source, now=0)
    release.expire(now=1000, timeout=500)
    assert not release.software


@pytest.mark.spec("C-139")
@pytest.mark.parametrize(("reading", "held"), [("every", False), ("bus", True)])
def test_a_setting_lets_it_end_those_of_a_bus_alone(reading, held):
    bench = Bench("charger", release_timeout=reading)
    put(bench, {0x02: 0x0C, 0x04: 500})
    bench.inject("hmi_on")
    bench.run(1.0)
    assert bool(status(bench) & 1 << 5) is held
    bench.sdo[0x6200][1].raw = 0x0F
    bench.run(1.0)
    assert status(bench) == 0


@pytest.mark.spec("C-141")
def test_the_timeout_is_no_message_and_a_new_release_undoes_it(charger, active):
    charger.write(Parameter.RELEASE_TIMEOUT, 500)
    charger.grant(ReleaseSource.CANOPEN)
    charger.step(0.6)
    assert not charger.release.software
    assert active(charger) == []
    charger.grant(ReleaseSource.CANOPEN)
    assert charger.charging_active
