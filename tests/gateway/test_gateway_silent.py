import json
import os
import signal
from threading import Timer

from canopen_twins.cli import main
from canopen_twins.cli import run as command


def test_whoever_is_not_on_the_bus_is_named_with_the_reason(capsys, caplog, monkeypatch):
    monkeypatch.setattr(command, "LONGEST_START", 0.4)
    Timer(1.5, os.kill, (os.getpid(), signal.SIGTERM)).start()
    assert main(["run", "gateway", "-n", "127", "-i", "virtual"]) == 0
    out, _ = capsys.readouterr()
    (why,) = json.loads(out.splitlines()[0])["silent"].values()
    assert "governor in the start tests" in why
    told = "gateway is still not on the bus: its CANopen state is "
    assert told in caplog.text
    assert "errors 3005" in caplog.text
