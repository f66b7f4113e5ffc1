"""A run with a control port, as the command line starts it."""

import json
import subprocess
import sys
from http.client import HTTPConnection
from urllib.parse import urlsplit

import pytest

from canopen_twins.cli import main

RUN = ("run", "topcon", "-n", "5", "-i", "virtual", "-c", "port")


def test_the_ready_line_tells_where_the_port_is():
    command = [sys.executable, "-m", "canopen_twins", *RUN, "--control"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        ready = json.loads(process.stdout.readline())
        try:
            connection = HTTPConnection(urlsplit(ready["control"]).netloc, timeout=30)
            connection.request("GET", "/nodes/topcon")
            answer = connection.getresponse()
            assert json.loads(answer.read())["node_id"] == 5
            connection.close()
        finally:
            process.terminate()
        _, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, b"")


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--control", "0.0.0.0:0"], "0.0.0.0:0 can be reached from other machines"),
        (["--control", "a:b:c"], "'a:b:c' is no address: write HOST:PORT"),
        (["--control", "192.0.2.1:1", "--control-token", "x"], "cannot listen on 192.0.2.1:1"),
        (["--control-token", "x"], "--control-token is for a port: say --control, too"),
    ],
)
def test_a_port_that_cannot_be_is_refused_in_a_line(capsys, options, told):
    assert main([*RUN, *options]) == 2
    err = capsys.readouterr().err
    assert told in err
    assert err.count("\n") == 1


def test_without_the_extra_a_line_says_what_to_install(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    assert main([*RUN, "--control"]) == 2
    told = "--control needs uvicorn: pip install 'canopen-twins[control]'\n"
    assert capsys.readouterr().err == f"canopen-twin: {told}"
