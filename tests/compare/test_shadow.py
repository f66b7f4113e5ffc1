import os
import signal
import time
from threading import Thread

import can
import pytest
from can.interfaces.virtual import channels

from canopen_twins import devices
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.python_can import frame_of, message_of
from canopen_twins.live.shadow import shadow
from canopen_twins.live.twin import LiveTwin
from canopen_twins.record.compare import Tolerances

ASKED = ["605#4018100400000000", "605#400A100000000000", "605#6000000000000000", "000#0105"]
OTHERS = ["000#8105", "605#4000100000000000", "185#R", "705#R", "7E5#5E00000000000000", "080#"]
PATIENCE = 20.0  # seconds


def wait_for_somebody_on(channel):
    """The shadow has opened its bus when python-can's virtual bus has somebody there."""
    end = time.monotonic() + PATIENCE
    while not channels.get(channel) and time.monotonic() < end:
        time.sleep(0.01)


@pytest.fixture
def beside(said, tmp_path):
    """`run --shadow` on a virtual bus, while somebody does something there: what it says."""

    def run(action, *options):
        bus = {"interface": "virtual", "channel": str(tmp_path)}

        def act():
            try:
                wait_for_somebody_on(bus["channel"])
                action(bus)
            finally:
                os.kill(os.getpid(), signal.SIGTERM)

        thread = Thread(target=act)
        thread.start()
        words = ("topcon", "-n", "5", "--shadow", "-i", "virtual", "-c", tmp_path, *options)
        outcome = said("run", *words)
        thread.join(PATIENCE)
        return outcome

    return run


def ask(bus, frames, patience=0.1):
    """Send, and hear all that comes."""
    heard = []
    with can.Bus(**bus) as master:
        for text in frames:
            master.send(message_of(Frame.parse(text)))
            end = time.monotonic() + patience
            while (left := end - time.monotonic()) > 0:
                if (message := master.recv(left)) is not None:
                    heard.append(str(frame_of(message)))
    return heard


def test_a_shadow_tells_differences_as_they_happen_and_sends_nothing(beside):
    heard = []

    def device_and_master(bus):
        with LiveTwin("topcon", {"node_id": 5, "serial": 7}, bus):
            heard.extend(ask(bus, ASKED))

    code, out, _ = beside(device_and_master, "--time", "5s")
    assert code == 1
    lines = out.splitlines()
    assert lines[0].startswith('{"shadow": "topcon", "interface": "virtual"')
    told = next(n for n, line in enumerate(lines) if line.startswith("SDO 0x1018:04 Identity"))
    assert "7, not 1" in lines[told]
    assert any(line.startswith("never exercised of topcon") for line in lines[told:])
    assert sum(text.startswith("585#") for text in heard) == 3  # of the device alone


def test_a_device_that_is_its_twin_has_no_difference(beside):
    def device_and_master(bus):
        with LiveTwin("topcon", {"node_id": 5}, bus):
            ask(bus, ASKED)

    code, out, _ = beside(device_and_master, "--time", "5s")
    assert (code, "100 %: " in out) == (0, True)


def test_whatever_a_master_sends_the_shadow_is_silent(beside):
    heard = ["something"]
    code, _, err = beside(lambda bus: heard.__setitem__(slice(None), ask(bus, ASKED + OTHERS)))
    assert heard == []
    assert (code, "the trace has nothing of node 5 (topcon)" in err) == (2, True)


class OnlyHeard(can.BusABC):
    """A bus that nobody may send on."""

    def __init__(self, frames):
        super().__init__("heard")
        self.frames = [message_of(Frame.parse(text)) for text in frames]

    def send(self, msg, timeout=None):
        pytest.fail(f"{msg} was sent")

    def _recv_internal(self, timeout):
        return (self.frames.pop(0) if self.frames else None), True


def test_there_is_no_way_from_the_twin_to_the_bus():
    bus = OnlyHeard(["705#00", *ASKED, *OTHERS])
    told = []
    twins = {"twin": devices.create("topcon", node_id=5)}
    shadow(twins, lambda: bus, lambda: not bus.frames, told.append, Tolerances(time=1))
    assert "only the twin sends it" in {str(each.kind) for each in told}


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--nvram", "x"), "--nvram"),
        (("--control",), "--control"),
        (("--words",), "--words"),
        (("--", "true"), "the COMMAND"),
    ],
)
def test_a_shadow_takes_no_part_in_anything(said, options, told):
    code, out, err = said("run", "topcon", "--shadow", "-i", "virtual", *options)
    assert (code, out) == (2, "")
    assert err == f"canopen-twin: --shadow takes no part in anything: leave {told} out\n"
