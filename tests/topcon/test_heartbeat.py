import pytest

from canopen_twins import Bench

from .bus import ENTER_PREOP, RESET_COMMUNICATION, RESET_NODE, START, STOP

EVERY_100_MS, NEVER = "605#2B17100064000000", "605#2B17100000000000"


@pytest.mark.spec("T-060")
@pytest.mark.parametrize("command", [ENTER_PREOP, START, STOP])
def test_there_is_no_heartbeat_unless_one_is_asked_for(topcon, command):
    assert topcon.sdo["Producer Heartbeat Time"].raw == 0
    topcon.send(command)
    assert topcon.run(3600) == []


@pytest.mark.spec("T-061", "A-23")
def test_it_comes_every_so_many_milliseconds(topcon):
    topcon.send(EVERY_100_MS)
    assert topcon.run(1.0) == 10 * ["705#7F"]
    times = [record.time for record in topcon.trace if str(record.frame) == "705#7F"]
    assert times == [pytest.approx(0.1 * n) for n in range(1, 11)]


@pytest.mark.spec("T-061")
@pytest.mark.parametrize("milliseconds", [1, 1000, 65535])
def test_every_period_of_16_bits_is_kept(topcon, milliseconds):
    topcon.sdo["Producer Heartbeat Time"].raw = milliseconds
    assert topcon.run(milliseconds / 1000) == ["705#7F"]
    assert topcon.run(milliseconds / 1000 * 3) == 3 * ["705#7F"]


@pytest.mark.spec("T-061")
def test_a_new_period_counts_from_its_write(topcon):
    topcon.send(EVERY_100_MS)
    topcon.run(0.09)
    topcon.sdo["Producer Heartbeat Time"].raw = 200
    assert topcon.run(0.199) == []
    assert topcon.run(0.001) == ["705#7F"]


@pytest.mark.spec("T-062", "A-02")
@pytest.mark.parametrize(("command", "content"), [(ENTER_PREOP, "7F"), (START, "05"), (STOP, "04")])
def test_it_shows_the_state(topcon, command, content):
    topcon.send(EVERY_100_MS)
    topcon.send(command)
    assert topcon.run(0.2) == 2 * [f"705#{content}"]


@pytest.mark.spec("T-062")
def test_its_identifier_follows_the_node_id():
    bench = Bench("topcon", node_id=127)
    bench.send("67F#2B17100064000000")
    assert bench.run(0.1) == ["77F#7F"]


@pytest.mark.spec("T-063")
def test_writing_0_stops_it(topcon):
    topcon.send(EVERY_100_MS)
    topcon.run(0.1)
    topcon.send(NEVER)
    assert topcon.run(10) == []


@pytest.mark.spec("T-064", "A-20")
@pytest.mark.parametrize("command", [RESET_NODE, RESET_COMMUNICATION])
def test_no_reset_brings_it_back(topcon, command):
    topcon.send(EVERY_100_MS)
    topcon.send("605#2310100173617665")  # save
    topcon.send(command)
    assert topcon.run(10) == []
    assert topcon.sdo["Producer Heartbeat Time"].raw == 0
    topcon.power_off()
    topcon.power_on()
    assert topcon.sdo["Producer Heartbeat Time"].raw == 0


@pytest.mark.spec("T-060", "A-76")
def test_it_ends_with_the_power(topcon):
    topcon.send(EVERY_100_MS)
    topcon.run(0.25)
    topcon.power_off()
    assert topcon.run(10) == []
