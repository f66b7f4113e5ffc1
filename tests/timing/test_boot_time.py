import pytest

from canopen_twins import Bench
from canopen_twins.diagnosis.why import why

READ = "605#4000100000000000"


@pytest.fixture(params=["topcon", "charger", "tests/probe.eds"])
def slow(request):
    return Bench(request.param, node_id=5, boot_time=0.5)


def test_nothing_is_sent_before_the_boot_time_is_over(slow):
    assert slow.run(0.499999) == []
    assert slow.run(0.000001) == ["705#00"]
    assert slow.clock.now == 0.5


def test_it_is_deaf_while_it_boots(slow):
    assert slow.send(READ) == []
    assert slow.state == "INITIALISING"
    slow.run(0.5)
    assert len(slow.send(READ)) == 1


@pytest.mark.parametrize("command", ["000#8105", "000#8205"])
def test_a_reset_takes_the_same_time(slow, command):
    slow.run(1.0)
    assert slow.send(command) == []
    assert slow.send(READ) == []
    assert slow.run(0.49) == []
    assert slow.run(0.01) == ["705#00"]


def test_a_power_cycle_while_it_boots_begins_anew(slow):
    slow.run(0.4)
    slow.power_off()
    assert slow.run(1.0) == []
    slow.power_on()
    assert slow.run(0.49) == []
    assert slow.run(0.01) == ["705#00"]


def test_why_says_that_it_boots(slow):
    slow.send(READ)
    told = why(slow.node, slow.trace)
    assert told[-1].startswith("the node is silent: it boots, which takes 0.5 s (boot_time)")


def test_in_ideal_it_boots_at_once():
    assert Bench("charger", node_id=5).sent[0] == "705#00"
