"""canopen's `LocalNode` as the slave: on a bench, where it takes no time, or on a real bus."""

import canopen

from canopen_twins.bus.segment import Segment
from canopen_twins.bus.wire import Wire
from canopen_twins.conform.bus import SimulatedBus
from canopen_twins.conform.run import conform
from canopen_twins.conform.tester import Slave

NODE_ID = 5


def local_slave(eds):
    """What a tester has to know of it."""
    return Slave("LocalNode", NODE_ID, canopen.import_od(str(eds), NODE_ID), str(eds))


class End:
    """An end of a segment with a LocalNode; remote frames are dropped, as its listener does."""

    def __init__(self, segment, eds):
        self.wire = Wire(segment.clock, segment.outbox, "LocalNode")
        self.wire.add_node(canopen.LocalNode(NODE_ID, str(eds)))

    def receive(self, frame):
        """A frame from the bus."""
        if not frame.remote:
            now = self.wire.clock.now
            self.wire.notify(frame.can_id, bytearray(frame.data), now)


def conform_local(eds, wanted=None):
    """The verdict on it in simulated time."""
    segment = Segment()
    segment.nodes.append(End(segment, eds))
    return conform(SimulatedBus(segment), local_slave(eds), wanted)
