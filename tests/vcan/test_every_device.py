import pytest

from canopen_twins import devices
from tests.vcan.bus import cansend

pytestmark = [pytest.mark.vcan, pytest.mark.parametrize("device", devices.names())]


def test_it_boots_answers_and_beats_as_can_utils_see_it(run, candump, device):
    twin = run(device, 5)
    silent = twin.ready.pop("silent", {})
    assert [*silent] == (["gateway"] if device == "gateway" else [])  # it starts up 0.3 s later
    assert twin.ready == {
        "ready": device,
        "node_id": 5,
        "interface": "socketcan",
        "channel": "vcan0",
    }
    assert candump.until("705#") == ["705#00"]
    cansend("605#2B17100064000000")  # a heartbeat every 100 ms, where the master may say so
    settable = devices.create(device).dictionary()[0x1017].writable
    answer = "585#6017100000000000" if settable else "585#8017100002000106"
    assert candump.until("705#")[-2:] == [answer, "705#7F"]
    cansend("000#0105")
    assert "705#05" in candump.until("705#05")
