"""What comes from a bus of python-can, whatever the clocks of the machine are set to."""

import time
from itertools import count

import can

from canopen_twins.bus.python_can import receive
from canopen_twins.live.bus import steady


def test_a_clock_on_the_wall_that_is_set_back_keeps_nobody_waiting(monkeypatch):
    backwards = count(1_000_000, -3600)
    monkeypatch.setattr(can.bus, "time", lambda: next(backwards))
    with can.Bus("set back", interface="virtual") as bus:
        begun = steady()
        assert receive(bus, 0.01) is None
        assert steady() - begun < 1.0


def test_what_a_filter_of_the_user_leaves_out_is_not_heard():
    filters = [{"can_id": 0x605, "can_mask": 0x7FF}]
    with (
        can.Bus("filtered", interface="virtual", can_filters=filters) as bus,
        can.Bus("filtered", interface="virtual") as master,
    ):
        for can_id in (0x606, 0x605):
            master.send(can.Message(arbitration_id=can_id, is_extended_id=False))
        heard = [receive(bus, 0.01) for _ in range(2)]
    assert [message and message.arbitration_id for message in heard] == [None, 0x605]


def test_a_test_that_freezes_its_clocks_does_not_stop_a_twin(monkeypatch):
    monkeypatch.setattr(time, "monotonic", lambda: 0.0)
    begun = steady()
    while steady() == begun:  # until the test's limit, if it stands still
        pass
