"""What test_workers.py has done in other processes, which start as fast as this imports."""

import os
import re
import signal
import time
from pathlib import Path

from canopen_twins.errors import UserError
from canopen_twins.hunt.workers import AHEAD, watched


def double(number):
    print("a master may print what it likes")
    return 2 * number


def die_once(folder, number):
    mark = Path(folder, str(number))
    if number == 3 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def die(number):
    os.kill(os.getpid(), signal.SIGKILL)


def hang(number):
    while number == 1:
        time.sleep(60)
    return number


def meet(pipe, number):
    """The first is done with the last that is asked for before it is."""
    if number in (0, 2 * AHEAD - 1):
        with Path(pipe).open("rb" if number == 0 else "wb"):
            pass
    return number


def hang_in_c(number):
    with watched():
        re.match("(a*)*b", "a" * 60)  # no line of Python is reached any more


def refuse(number):
    raise UserError(f"{number} cannot be")


def break_down(number):
    raise KeyError(number)
