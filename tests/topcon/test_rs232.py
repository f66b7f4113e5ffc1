import pytest

from canopen_twins import Bench

from .bus import START, STOP


def rs232(bench):
    return bench.device.panel.rs232_available


@pytest.mark.spec("T-090")
def test_the_only_rs232_port_is_that_of_the_card(topcon):
    ports = [name for name in topcon.device.report if "RS-232" in name]
    assert ports == ["RS-232 of the card"]


@pytest.mark.spec("T-091")
def test_no_rs232_in_operational(topcon):
    topcon.send(START)
    topcon.run(5.0)
    assert not rs232(topcon)


@pytest.mark.spec("T-092", "A-07")
def test_rs232_in_pre_operational_once_no_frame_has_come_for_a_second(topcon):
    topcon.run(0.999)
    assert not rs232(topcon)
    topcon.run(0.001)
    assert rs232(topcon)
    assert topcon.device.report["RS-232 of the card"] == "available"
    topcon.send("606#4000100000000000")  # for somebody else
    assert rs232(topcon)
    topcon.send("605#4000100000000000")
    assert not rs232(topcon)
    assert topcon.device.report["RS-232 of the card"] == "closed"


@pytest.mark.spec("T-092", "A-07")
def test_what_the_node_sends_is_communication_over_the_bus_as_well(topcon):
    topcon.sdo["Producer Heartbeat Time"].raw = 800
    for _ in range(50):
        topcon.run(0.1)
        assert not rs232(topcon)
    topcon.sdo["Producer Heartbeat Time"].raw = 1500
    topcon.run(1.4)
    assert rs232(topcon)
    assert topcon.run(0.2) == ["705#7F"]
    assert not rs232(topcon)


@pytest.mark.spec("T-092", "A-07")
def test_an_emergency_closes_rs232(topcon):
    topcon.run(2.0)
    assert rs232(topcon)
    topcon.inject("error", number=0x23)
    assert not rs232(topcon)


@pytest.mark.spec("A-07")
@pytest.mark.parametrize(("seconds", "open_after"), [(0.0, 0.0), (0.25, 0.25)])
def test_how_long_the_bus_has_to_be_quiet(seconds, open_after):
    bench = Bench("topcon", node_id=5, quiet_time=seconds)
    assert rs232(bench) == (seconds == 0.0)
    bench.run(open_after)
    assert rs232(bench)


@pytest.mark.spec("A-07")
def test_no_rs232_in_stopped(topcon):
    topcon.send(STOP)
    topcon.run(5.0)
    assert not rs232(topcon)
