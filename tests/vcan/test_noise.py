import re
import subprocess
import time
from itertools import pairwise
from statistics import median

import pytest

from tests.vcan.bus import CHANNEL, Process
from tests.vcan.client import Client

pytestmark = pytest.mark.vcan

SECONDS = 30.0
# never of two bytes: that would be a command to the node, once in a while
NOISE = (
    ("cangen", CHANNEL, "-g", "0", "-i", "-L", "8"),
    ("cangen", CHANNEL, "-g", "0", "-i", "-m", "-L", "1"),  # extended, remote and FD, too
)
VENDOR = "40181001"
BEAT = "2B17100064000000"  # a heartbeat every 100 ms


@pytest.fixture
def client(run):
    # what comes at random has its identifiers, too
    run("topcon", 5).may_say = rb"another node on the bus has node id 5"
    with Client(5) as client:
        assert client.ask(BEAT)[0] == "6017100000000000"
        yield client


def test_noise_at_full_speed_gets_no_wrong_answer_out_of_a_twin(stack, client, capsys):
    right, _ = client.ask(VENDOR)
    load = stack.enter_context(Process("canbusload", f"{CHANNEL}@1000000"))
    for command in NOISE:
        stack.enter_context(Process(*command))
    end = time.monotonic() + SECONDS
    answers, took = [], []
    while time.monotonic() < end:
        answer, seconds = client.ask(VENDOR)
        answers.append(answer)
        took.append(seconds)
    load.stop()
    rates = [int(rate) for rate in re.findall(rb"@1000000 +(\d+)", load.out)]
    silence = max(later - before for before, later in pairwise(client.beats))
    with capsys.disabled():
        print(
            f"\n{SECONDS:g} s of noise, {median(rates)} frames/s: {len(took) - answers.count(None)}"
            f" of {len(took)} requests answered, p50 {1000 * median(took):.0f} ms;"
            f" heartbeats every 100 ms {1000 * silence:.0f} ms apart at most"
        )
    assert set(answers) <= {right, None}
    assert answers.count(right) > len(answers) / 2  # a full queue loses frames, as a real one does
    assert silence < 1.0
    assert median(rates) > 2000  # so many fit on a bus of 1 Mbit/s, and half as many again


def test_random_requests_are_refused_one_by_one(client):
    right, _ = client.ask(VENDOR)
    subprocess.run(["cangen", CHANNEL, "-g", "0", "-i", "-I", "605", "-n", "5000"], check=True)
    while (answer := client.ask(VENDOR)[0]) is None:
        pass  # still busy, or the answer was one too many for our queue
    assert answer == right
