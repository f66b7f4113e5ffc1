"""A `run` in the process of the tests, which is told to end as soon as it is ready."""

import json
import os
import signal
from collections.abc import Callable
from contextlib import redirect_stdout
from io import StringIO
from typing import Any, NamedTuple

from canopen_twins.cli import main


class Ended(NamedTuple):
    """How a run has ended, and what it said on stdout when it was ready and afterwards."""

    code: int
    ready: dict[str, Any]
    said: str


class _ToldToEnd(StringIO):
    """With the first line comes SIGTERM, which `run` waits for in this thread."""

    def __init__(self, then: Callable[[], None]) -> None:
        super().__init__()
        self.then = then

    def write(self, text: str) -> int:
        told = "\n" in self.getvalue()
        written = super().write(text)
        if not told and "\n" in text:
            self.then()
            os.kill(os.getpid(), signal.SIGTERM)
        return written


def run_until_ready(*arguments: object, then: Callable[[], None] = lambda: None) -> Ended:
    """Run twins as `canopen-twin run` does, do something when they are ready, and end them."""
    with redirect_stdout(_ToldToEnd(then)) as out:
        code = main(["run", *map(str, arguments)])
    ready, _, said = out.getvalue().partition("\n")
    return Ended(code, json.loads(ready), said)
