"""Who is on vcan0 in these tests: twins in processes of their own, can-utils, a canopen master."""

import json
import re
import selectors
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

import canopen

CHANNEL = "vcan0"
PATIENCE = 30.0  # seconds; only what is broken takes so long
BACKLOG = 1 << 22  # bytes; by itself a witness that is held up loses what 250 frames do not hold
STALL = rb"stood still for|of real time are left out"  # of the machine, and true when it is said


class Lines:
    """What a process says, line by line, without waiting for longer than told."""

    def __init__(self, pipe):
        self._pipe = pipe
        self._rest = b""
        self._selector = selectors.DefaultSelector()
        self._selector.register(pipe, selectors.EVENT_READ)

    def next(self, within=PATIENCE):
        """The next line, none if there is none in time or the process has ended."""
        end = time.monotonic() + within
        while b"\n" not in self._rest:
            if not self._selector.select(max(end - time.monotonic(), 0)):
                return None
            chunk = self._pipe.read1()
            if not chunk:
                return None
            self._rest += chunk
        line, self._rest = self._rest.split(b"\n", 1)
        return line.decode()

    def until(self, pattern, within=PATIENCE):
        """The lines up to the first that has the pattern in it."""
        end = time.monotonic() + within
        lines = []
        while not lines or not re.search(pattern, lines[-1]):
            line = self.next(max(end - time.monotonic(), 0))
            assert line is not None, f"no {pattern} in {lines}"
            lines.append(line)
        return lines


class Process:
    """A process that ends with its block."""

    def __init__(self, *command, end=signal.SIGTERM, **options):
        options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
        self.process = subprocess.Popen(command, **options)
        self.end = end

    def __enter__(self):
        return self

    def __exit__(self, *failure):
        self.stop()

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(self.end)
        self.out, self.err = self.process.communicate(timeout=PATIENCE)


class Twin(Process):
    """`canopen-twin run` on vcan0, which has to end well, without a word that it may not say."""

    may_say = rb"\b\B"  # nothing

    def __init__(self, device, node_id, *options):
        command = [sys.executable, "-m", "canopen_twins", "run", device, "-n", str(node_id)]
        command += ["--set", "timing=ideal"]  # what is measured is the device, without noise
        super().__init__(*command, "-i", "socketcan", "-c", CHANNEL, *options)
        ready = Lines(self.process.stdout).next()
        assert ready, self.process.communicate(timeout=PATIENCE)[1].decode()
        self.ready = json.loads(ready)

    def stop(self):
        super().stop()
        may_say = re.compile(rb"%b|%b" % (STALL, self.may_say))
        told = [line for line in self.err.splitlines() if not may_say.search(line)]
        if self.process.returncode or self.out or told:
            raise AssertionError(f"{self.process.returncode}: {self.out!r} {self.err.decode()}")


class Candump(Process):
    """Everything on the bus, as `candump -L` tells it."""

    def __init__(self, *filters):
        super().__init__("candump", "-L", "-r", str(BACKLOG), CHANNEL)
        self.lines = Lines(self.process.stdout)
        while not self.lines.next(within=0.05):  # it hears from now on
            cansend("7FF#")
        while self.lines.next(within=0.05):
            pass

    def until(self, frame, within=PATIENCE):
        """The frames up to the first that begins like this."""
        lines = self.lines.until(f" {CHANNEL} {frame}", within)
        return [line.split()[-1] for line in lines]


def cansend(*frames):
    for frame in frames:
        subprocess.run(["cansend", CHANNEL, frame], check=True)


@contextmanager
def master():
    network = canopen.Network()
    network.NOTIFIER_CYCLE = 0.005  # what it takes to leave the bus
    network.connect(interface="socketcan", channel=CHANNEL)
    with network:
        yield network
