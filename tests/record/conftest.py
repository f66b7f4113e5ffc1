import os
import signal
from collections.abc import Callable
from threading import Event, Thread

import can
import pytest

from canopen_twins.cli import main

from .master import PATIENCE, Master

STORY = """\
version: 1
name: A heartbeat, an error, a command
node: {device: topcon, node_id: 5, settings: {load: resistor 4}}
steps:
  - {at: 0.1, write: {Producer Heartbeat Time: 100}}
  - {at: 0.2, inject: {error: {number: 0x23}}}
  - {at: 0.2, expect: {emcy: {code: 0x2300}, within: 0.05}}
  - {at: 0.4, nmt: start}
  - {at: 0.4, expect: {heartbeat: operational, within: 0.2}}
  - {at: 0.7, clear: all}
"""


def edit(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


@pytest.fixture
def said(capsys):
    """Run a command in this process: its exit code and what it said on stdout and stderr."""

    def run(*arguments):
        code = main([str(argument) for argument in arguments])
        return code, *capsys.readouterr()

    return run


@pytest.fixture
def story(tmp_path):
    """A file with a scenario."""

    def write(text=STORY, name="story.yaml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def recorded(said, story, tmp_path):
    """A record of a scenario that was played."""

    def play(text=STORY, name="record"):
        code, _, err = said("play", story(text), "--record", tmp_path / name)
        assert (code, err) == (0, "")
        return tmp_path / name

    return play


@pytest.fixture
def live(said, tmp_path) -> Callable[..., tuple[int, str, str]]:
    """A run on python-can's virtual bus, beside a master that ends it when it has done its work."""

    def run(master, *arguments):
        over, failures = Event(), []

        def work(bus):
            try:
                master(Master(bus))
            except BaseException as failure:
                failures.append(failure)
            finally:
                if not over.is_set():
                    os.kill(os.getpid(), signal.SIGTERM)

        with can.Bus(interface="virtual", channel=str(tmp_path)) as bus:
            thread = Thread(target=work, args=(bus,))
            thread.start()
            done = said("run", *arguments, "-i", "virtual", "-c", tmp_path)
            over.set()
            thread.join(PATIENCE)
        for failure in failures:
            raise failure
        return done

    return run
