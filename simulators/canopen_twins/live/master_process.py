"""The process of a master: a command that is told where the bus is, from its start to its end."""

import json
import os
import shutil
import signal
import socket
import subprocess
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.errors import UserError
from canopen_twins.live.bus import steady

GRACE = 5.0  # seconds from SIGTERM to SIGKILL
NAP = 0.01  # seconds
SOCKETCAND = "socketcand"
GROUPS = hasattr(os, "killpg")  # else only the process itself can be ended
KILL = getattr(signal, "SIGKILL", signal.SIGTERM)


@dataclass(frozen=True)
class BusPlace:
    """Where the bus of a run is, as python-can names it."""

    interface: str
    channel: str
    hub: HubAddress | None = None

    @classmethod
    def on_hub(cls, address: HubAddress, channel: str) -> Self:
        """A bus of a hub."""
        return cls(SOCKETCAND, channel, address)

    def filled(self, command: Sequence[str]) -> list[str]:
        """A command with the place where it says {interface}, {channel} or {hub}.

        Raises:
            UserError: it asks for a hub, and there is none.
        """
        words = {"{interface}": self.interface, "{channel}": self.channel}
        if self.hub is not None:
            words["{hub}"] = str(self.hub)
        elif any("{hub}" in part for part in command):
            raise UserError("the command asks for {hub}, but this run is on none: say --hub")
        filled = list(command)
        for word, value in words.items():
            filled = [part.replace(word, value) for part in filled]
        return filled

    @property
    def options(self) -> Mapping[str, Any]:
        """What python-can opens: `can.Bus(**place.options)`."""
        named = {"interface": self.interface, "channel": self.channel}
        if self.hub is None:
            return named
        where: dict[str, Any] = {"host": self.hub.host, "port": self.hub.port}
        if hasattr(socket, "TCP_QUICKACK"):  # else python-can's client waits for 40 ms
            where["tcp_tune"] = True
        return named | where

    @property
    def environment(self) -> Mapping[str, str]:
        """What `can.Bus()` without arguments reads, and CANOPEN_HUB for others."""
        where = dict(self.options)
        given = {"CAN_INTERFACE": where.pop("interface"), "CAN_CHANNEL": where.pop("channel")}
        if self.hub is None:
            return given
        return {**given, "CAN_CONFIG": json.dumps(where), "CANOPEN_HUB": str(self.hub)}


class MasterProcess:
    """A command and all that it starts, in a process group of their own.

    As a context it is started, and ended at the end: told to (SIGTERM), then killed. Whoever serves
    twins meanwhile calls `ask_to_end` and looks at `gone`, neither of which waits.
    """

    def __init__(
        self, command: Sequence[str], place: BusPlace, grace: float = GRACE, **streams: Any
    ) -> None:
        """Raises `UserError` as `BusPlace.filled` does, and where there is no such program.

        Args:
            command: A program and its arguments.
            place: Put into the command and its environment.
            grace: Seconds that it may take from SIGTERM on.
            streams: stdin, stdout and stderr as for `subprocess.Popen`; ours if left out.
        """
        self._words = " ".join(command)  # the same in every run: names of tests have it
        self._command = place.filled(command)
        if shutil.which(self._command[0]) is None:  # said before anybody is told it is ready
            raise UserError(f"{self._command[0]}: no such program, or none that may be run")
        self._environment = {**os.environ, **place.environment}
        self._grace = grace
        self._streams = streams
        self._process: subprocess.Popen[bytes] | None = None
        self._deadline: float | None = None  # from when on it is killed
        self._code_when_asked: int | None = None

    def start(self) -> None:
        """Start it.

        Raises:
            UserError: there is no such program, or it may not be run.
        """
        try:
            self._process = subprocess.Popen(
                self._command, env=self._environment, start_new_session=GROUPS, **self._streams
            )
        except OSError as failure:
            raise UserError(
                f"{self._command[0]} cannot be started: {failure.strerror}"
            ) from failure

    @property
    def code(self) -> int | None:
        """Its exit code, negative for a signal; none while it runs, or is not yet started."""
        return None if self._process is None else self._process.poll()

    @property
    def failure(self) -> str:
        """How it has ended by itself, in words; empty if all is well, or it was told to end."""
        code = self.code if self._deadline is None else self._code_when_asked
        if not code:
            return ""
        if code > 0:
            return f"has ended with exit code {code}"
        return f"has been ended by signal {-code} ({signal.strsignal(-code)})"

    def ask_to_end(self) -> None:
        """Tell it to end; what it does from now on is no failure."""
        if self._deadline is None:
            self._code_when_asked = self.code
            self._deadline = steady() + self._grace
            self._signal(signal.SIGTERM)

    @property
    def gone(self) -> bool:
        """Whether nothing of it is left; what is still there when its time is up is killed."""
        if self._process is None:
            return True
        if self._deadline is not None and steady() >= self._deadline:
            self._signal(KILL)
            return self.code is not None  # zombies that nobody reaps stay in the group for ever
        return self.code is not None and not (GROUPS and self._signal(0))

    def end(self) -> None:
        """Tell it to end, and wait until it has."""
        self.ask_to_end()
        while not self.gone:
            time.sleep(NAP)

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.end()

    def __str__(self) -> str:
        return self._words

    def _signal(self, number: int) -> bool:
        """Whether there was somebody to get it."""
        if self._process is None:
            return False
        if not GROUPS:
            self._process.send_signal(number)
            return self._process.poll() is None
        try:
            os.killpg(self._process.pid, number)
        except (ProcessLookupError, PermissionError):  # the latter: macOS, of a group of zombies
            return False
        return True
