"""A slave with LSS on vcan0, node 5 at first, until SIGTERM."""

import signal

import can

from simulators.segment import Segment
from simulators.serve import serve
from tests.services.test_lss import Settable
from tests.vcan.bus import CHANNEL

told = []
signal.signal(signal.SIGTERM, lambda *signals: told.append(signals))
segment = Segment()
segment.node(Settable(), "settable").power_on()
serve(segment, lambda: can.Bus(interface="socketcan", channel=CHANNEL), lambda: bool(told))
