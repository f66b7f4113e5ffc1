import pytest
from probe import Probe

from canopen_twins import Bench
from canopen_twins.bus.segment import Segment
from canopen_twins.diagnosis.why import why
from canopen_twins.faults import connect

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


class Growing(Probe):
    """The steps of its model so far, and its level, are in the dictionary it boots with."""

    asked = 0

    def dictionary(self):
        od = super().dictionary()
        od[0x2003].default = len(self.steps) + self.settings.level
        self.asked += 1
        return od


def value(node):
    return int.from_bytes(node.slave.data_store[0x2003][0], "little")


def test_a_boot_leaves_room_for_frames_between_its_parts():
    segment, device = Segment(), Growing(boot_time=0.5)
    node = connect(segment, device, "probe")
    node.power_on()
    parts = []
    while node.slave is None:
        segment.advance_to(segment.clock.next_deadline)
        parts.append(500_000 - segment.clock.ticks)
    assert parts == [2, 1, 0]  # microseconds left
    assert device.asked == 1


def test_a_device_that_moves_boots_with_the_dictionary_of_its_last_step():
    device = Growing(boot_time=0.5)
    device.rest = 0
    bench = Bench({"probe": device})
    bench.run(0.5)
    assert value(bench.twins["probe"].node) == len(device.steps) > 1


@pytest.mark.parametrize("left", [3, 2, 1])
def test_what_is_set_shortly_before_the_end_of_a_boot_is_in_its_dictionary(left):
    bench = Bench({"probe": Growing(boot_time=0.5)})
    twin = bench.twins["probe"]
    bench.run(0.5 - left / 1e6)
    twin.set(level=70)
    bench.run(0.1)
    assert value(twin.node) > 70
