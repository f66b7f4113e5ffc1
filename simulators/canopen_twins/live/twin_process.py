"""Twins in a process of their own, as `canopen-twin run` has them: on a bus for any master."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from types import TracebackType
from typing import Any, Self

from canopen_twins.errors import UserError
from canopen_twins.live.bus import steady
from canopen_twins.live.master_process import BusPlace

PATIENCE = 20.0  # seconds for it to boot, or to end: a CI machine may be busy
NAP = 0.005  # seconds
BUG = "Traceback (most recent call last)"
PROGRAM = (sys.executable, "-P", "-m", "canopen_twins", "run")


class TwinProcess(AbstractContextManager["TwinProcess"]):
    """A process of `canopen-twin run`, which ends with the block, or with this process.

    A bug in a twin, as far as nothing else has gone wrong, is a `RuntimeError` at the end.

    Args:
        arguments: As on the command line, without the bus.
        place: Which bus it is on.
    """

    def __init__(self, arguments: Sequence[str], place: BusPlace) -> None:
        self.bus: Mapping[str, Any] = place.options
        """What to open to be on the same bus: `can.Bus(**twin.bus)`."""
        self.ready: Mapping[str, Any] = {}
        """What its `ready` line says."""
        where = ("-i", place.interface) if place.hub is None else ("--hub", str(place.hub))
        self._command = [*PROGRAM, *arguments, *where, "-c", place.channel]
        self._output = tempfile.TemporaryFile()  # noqa: SIM115 - open for as long as this is
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        """Raises `UserError` with what it says if it cannot be run."""
        self._process = subprocess.Popen(
            [*self._command, "--parent", str(os.getpid())],
            stdout=self._output,
            stderr=self._errors,
            start_new_session=True,  # Ctrl-C is for the tests, which end it
        )
        end = steady() + PATIENCE
        while b"\n" not in (said := _read(self._output)):
            if self._process.poll() is not None or steady() > end:
                self.end()
                told = self.errors.strip() or f"not ready within {PATIENCE:.0f} s"
                self._close()
                raise UserError(told)
            time.sleep(NAP)
        self.ready = json.loads(said.partition(b"\n")[0])
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.end()
        errors = self.errors
        self._close()
        if value is None and BUG in errors:
            raise RuntimeError(errors)

    @property
    def output(self) -> str:
        """What it has said on stdout: the ready line, and the verdict of a scenario."""
        return _read(self._output).decode(errors="replace")

    @property
    def errors(self) -> str:
        """What it has said on stderr."""
        return _read(self._errors).decode(errors="replace")

    def wait(self, seconds: float = PATIENCE) -> int:
        """Its exit code when it ends by itself, as at the end of a scenario: 0 for PASS.

        Raises:
            TimeoutError: it runs for longer.
        """
        assert self._process is not None
        try:
            return self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            raise TimeoutError(f"the twins still run after {seconds:g} s") from None

    def end(self) -> int:
        """End it, if it still runs; its exit code."""
        assert self._process is not None
        self._process.terminate()
        try:
            return self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            return self._process.wait()

    def _close(self) -> None:
        self._output.close()
        self._errors.close()

    def scene(self) -> str:
        """What it has said, for somebody who asks why a test has failed."""
        return f"{self.output}{self.errors}".rstrip()


def _read(file: Any) -> bytes:
    """What is in a file that another process writes; its place there stays."""
    return os.pread(file.fileno(), os.fstat(file.fileno()).st_size, 0)
