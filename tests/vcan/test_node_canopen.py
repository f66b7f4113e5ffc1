import json
import os
import shutil
import socket
import subprocess
from pathlib import Path

import pytest

from canopen_twins.files.shipped import od_file
from canopen_twins.slave.dictionary import dictionary
from tests.vcan.bus import CHANNEL, PATIENCE

SCRIPT = Path(__file__).with_name("node_canopen.js")
MODULES = Path(os.environ.get("NODE_PATH", ""))

pytestmark = [
    pytest.mark.vcan,
    pytest.mark.skipif(
        not (shutil.which("node") and (MODULES / "canopen").is_dir()),
        reason="needs node, and NODE_PATH to where `npm install canopen` was done",
    ),
]


@pytest.fixture
def found(run):
    """What a master in JavaScript finds at a twin."""
    run("topcon", 5)
    with (
        od_file("topcon.eds") as eds,
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as can,
    ):
        can.bind((CHANNEL,))
        done = subprocess.run(
            ["node", str(SCRIPT), str(eds), "5"],
            stdin=can,
            capture_output=True,
            timeout=PATIENCE,
            check=False,
        )
    assert done.returncode == 0, done.stderr.decode()
    return json.loads(done.stdout)


def test_a_twin_is_what_node_canopen_expects_of_a_slave(found):
    assert found == {
        "entries": len([index for index in dictionary("topcon.eds", 5) if index >= 0x1000]),
        "identity": [0x1C4, 0, 9, 1],
        "hardware": "V4.x",
        "refusal": 0x06020000,
        "heartbeat": {"deviceId": 5, "state": 0x7F},
        "operational": {"deviceId": 5, "state": 0x05},
        "voltage": 2000,
        "pdo": [2000, 0, 0, 3],
        "emergency": [0x3300, 0x05],
    }
