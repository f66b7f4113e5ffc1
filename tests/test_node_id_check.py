import can
import pytest
from can.interfaces.virtual import VirtualBus, channels

from canopen_twins.bus.frame import Frame
from canopen_twins.errors import UserError
from canopen_twins.live.bus import with_node_id_check

PATIENCE = 5.0


@pytest.fixture
def bus(request):
    """Opens the bus of this test."""
    return lambda: VirtualBus(request.node.name)


@pytest.fixture
def other(bus):
    with bus() as other:
        yield other


@pytest.fixture
def opened(bus, other):
    """Opens the bus while somebody else sends frames."""

    def opened(*frames, seconds=PATIENCE):
        def open_bus():
            mine = bus()
            for text in frames:
                can_id, data, remote, extended = Frame.parse(text)
                other.send(
                    can.Message(
                        arbitration_id=can_id,
                        data=data,
                        is_remote_frame=remote,
                        is_extended_id=extended,
                    )
                )
            return mine

        return with_node_id_check(open_bus, [5, 9], seconds)

    return opened


@pytest.mark.parametrize("frame", ["705#7F", "709#00", "585#4000100000000000", "089#0081"])
def test_whoever_has_the_node_id_already_is_found_and_the_bus_is_left(opened, frame, other):
    with pytest.raises(UserError, match=rf"^node [59] is on the bus already: .* {frame}$"):
        opened("706#05", frame)()
    assert channels[other.channel_id] == [other.queue]


OTHERS = ["704#05", "605#4000100000000000", "705#R", "00000705#00", "080#", "000#0105", "185#00"]


def test_frames_of_others_do_not_matter(opened):
    opened(*OTHERS, seconds=0.01)().shutdown()


def test_nothing_is_sent(opened, other):
    opened(seconds=0.01)().shutdown()
    assert other.recv(0) is None


def test_it_is_asked_when_the_bus_is_opened_first_and_never_again(bus, other):
    heard = []

    def open_bus():
        mine = bus()
        heard.append(other.send(can.Message(arbitration_id=0x709, is_extended_id=False)))
        return mine

    opening = with_node_id_check(open_bus, [5], 0.01)
    opening().shutdown()  # node 9 is somebody else
    again = with_node_id_check(open_bus, [9], PATIENCE)
    with pytest.raises(UserError):
        again()
    again().shutdown()  # a bus that failed is opened again: what is there now is ours, too
    assert len(heard) == 3
