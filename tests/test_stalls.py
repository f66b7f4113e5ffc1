"""What a device sends while time is made up for that has passed unseen, as after a stall."""

from collections import Counter

import pytest

from canopen_twins import Bench, devices
from canopen_twins.bus.clock import Clock, microseconds

STALL = 10.0  # seconds: some devices have heartbeats of a second


@pytest.mark.parametrize("device", devices.names())
def test_no_device_sends_its_backlog(device):
    bench = Bench(device, node_id=5)
    bench.send("605#2B17100010000000")  # a heartbeat every 16 ms, as far as the device takes it
    bench.send("000#0105")
    bench.run(1.0)
    usual = Counter(frame.partition("#")[0] for frame in bench.run(STALL))
    bench.clock.unseen = microseconds(bench.clock.now + STALL)
    late = Counter(frame.partition("#")[0] for frame in bench.run(STALL))
    assert max(usual.values()) >= 5
    assert late.keys() == usual.keys()
    assert max(late.values()) <= 2
    after = Counter(frame.partition("#")[0] for frame in bench.run(STALL))
    assert all(abs(after[each] - usual[each]) <= 1 for each in usual)


def test_what_is_called_every_period_is_called_once_for_those_that_have_passed():
    clock, called = Clock(), []
    clock.every(0.1, lambda: called.append(round(clock.now, 3)))
    clock.advance(0.25)
    clock.unseen = microseconds(1.05)
    clock.advance(0.75)
    assert called == [0.1, 0.2, 0.3]
    clock.advance(0.25)
    assert called == [0.1, 0.2, 0.3, 1.1, 1.2]
