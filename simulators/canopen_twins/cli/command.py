"""What commands share: a parser, the options of a device, signals, and the exit codes."""

import argparse
import os
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from itertools import chain
from math import inf
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn

from canopen_twins.errors import UserError
from canopen_twins.live.parent import Parent

OK = 0
FAILED = 1
"""An expectation failed, or two runs are not the same; also a bug, with its traceback."""
WRONG_INPUT = 2
SIGNALLED = 128
"""And the number of the signal, as shells have it."""
INTERRUPTED = 130
"""By SIGINT, as shells have it."""
NO_READER = 141
"""Whoever read our output has seen enough; as of SIGPIPE."""

DEVICE = "one of `canopen-twin list`, or a device file, EDS, DCF, XDD or XDC"
SCENARIO = "a file, or the name of one that is shipped"
PLOT = "draw the run: .png, .svg or .html (needs the extra `plot`)"


class OneLineParser(argparse.ArgumentParser):
    """What is wrong is told in one line; how it is used tells --help."""

    def error(self, message: str) -> NoReturn:
        """End with that line."""
        self.exit(WRONG_INPUT, f"{self.prog}: {message}\n")


class Parser(OneLineParser):
    """The parser of a command, which is empty until the command is chosen."""

    complete: "Callable[[Parser], None] | None" = None
    takes_command = False
    """Whether what stands behind `--` is a command to be run, `words` of the options."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._outputs: list[str] = []

    def add_output(self, name: str, text: str, metavar: str = "FILE") -> None:
        """An option for what is written, which must not take the place of anything that is read."""
        action = self.add_argument(name, type=Path, metavar=metavar, help=text)
        self._outputs.append(action.dest)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse, after everything is there."""
        self.fill()
        if self.takes_command:
            args = list(args)
            end = args.index("--") if "--" in args else len(args)
            self.set_defaults(words=args[end + 1 :])
            if args[end:] == ["--"]:
                self.error("a COMMAND is wanted behind --")
            args = args[:end]
        options, others = super().parse_known_args(args, namespace)
        self._keep_apart(vars(options))
        return options, others

    def _keep_apart(self, options: Mapping[str, Any]) -> None:
        outputs = [options[dest] for dest in self._outputs if options[dest] is not None]
        others = [value for dest, value in options.items() if dest not in self._outputs]
        named = chain(*(each if isinstance(each, list) else [each] for each in others))
        inputs = [each for each in named if isinstance(each, (str, Path)) and _is_plain(each)]
        taken = {_real(each) for each in inputs}
        for output in outputs:
            if _real(output) in taken and not _is_special(output):
                self.error(f"{output} would take the place of another file that is named here")
            taken.add(_real(output))

    def fill(self) -> None:
        """Take what the command has to say, once."""
        complete, self.complete = self.complete, None
        if complete is not None:
            complete(self)


def _is_plain(name: str | Path) -> bool:
    with suppress(OSError, ValueError):  # a name that is too long, or has a zero in it
        return Path(name).is_file()
    return False


def _is_special(path: Path) -> bool:
    """Whether it is a device or a pipe, in which nothing is lost."""
    with suppress(OSError, ValueError):
        return path.exists() and not path.is_file() and not path.is_dir()
    return False


def _real(path: str | Path) -> str:
    with suppress(OSError, ValueError):  # the working directory is gone
        return os.path.realpath(path)
    return str(path)


def add_verbosity(parser: argparse.ArgumentParser, default: Any = argparse.SUPPRESS) -> None:
    """-v and -q, which may stand before the name of a command or behind it."""
    text = "tell more; -vv the most"
    parser.add_argument("-v", "--verbose", action="count", default=default, help=text)
    text = "tell less: no warnings"
    quiet = False if default == 0 else default
    parser.add_argument("-q", "--quiet", action="store_true", default=quiet, help=text)


def node_id(text: str) -> int:
    """A node id as it is written on a command line; whether a device can have it says the device.

    Raises:
        argparse.ArgumentTypeError: it is no whole number.
    """
    try:
        return int(text, 0)
    except ValueError:
        told = f"a node id is a whole number of 1..127, such as 5 or 0x05, not {text!r}"
        raise argparse.ArgumentTypeError(told) from None


def seconds(text: str) -> float:
    """A time as it is written on a command line.

    Raises:
        argparse.ArgumentTypeError: it is no finite number above 0.
    """
    with suppress(ValueError):
        if 0 < (time := float(text)) < inf:
            return time
    raise argparse.ArgumentTypeError(f"a time is a number of seconds above 0, not {text!r}")


def add_json(parser: argparse.ArgumentParser) -> None:
    """--json."""
    parser.add_argument("--json", action="store_true", help="for programs")


def add_device(parser: Parser, text: str = DEVICE, nargs: str | None = None) -> None:
    """A device, and how it is delivered."""
    parser.add_argument("device", metavar="DEVICE", nargs=nargs, help=text)
    parser.add_argument("-n", "--node-id", type=node_id, metavar="ID", help="1..127, or as 0x05")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="see `settings DEVICE`"
    )
    parser.add_argument("--config", metavar="FILE", help="short for --set config=FILE")


def add_parent(parser: Parser) -> None:
    """The process that is served."""
    text = "end when this process ends, however that comes"
    parser.add_argument("--parent", type=int, metavar="PID", help=text)


def parent(options: argparse.Namespace) -> Parent | None:
    """The process of `--parent`; that which has called us, if we run a command.

    Raises:
        UserError: there is no such process.
    """
    if options.parent is not None:
        return Parent(options.parent)
    caller = os.getppid() if getattr(options, "words", None) else 0  # 0: we are the first process
    return Parent(caller) if caller else None


def device_settings(options: argparse.Namespace) -> dict[str, object]:
    """Settings by name, from `--node-id`, `--config` and every `--set KEY=VALUE`.

    Raises:
        UserError: a setting without a value.
    """
    settings: dict[str, object] = {}
    for text in options.set:
        key, equals, settings[key] = text.partition("=")
        if not equals:
            raise UserError(f"--set {text}: write it as KEY=VALUE")
    given = {"config": options.config, "node_id": options.node_id}
    return settings | {key: value for key, value in given.items() if value is not None}


class Signals(list[int]):
    """The signals by which somebody has told us to end."""

    asks_for_state = False
    """Whether SIGUSR1 has come, which does not."""

    @property
    def code(self) -> int:
        """The exit code of a command that ends because of them."""
        return INTERRUPTED if signal.SIGINT in self else OK


@contextmanager
def catch_signals() -> Iterator[Signals]:
    """SIGINT, SIGTERM and SIGHUP are wishes: what is under way is finished first.

    A SIGHUP that is ignored, as under nohup, stays so.
    """
    caught = Signals()

    def catch(number: int, frame: FrameType | None) -> None:
        caught.append(number)

    def ask(number: int, frame: FrameType | None) -> None:
        caught.asks_for_state = True

    handlers = dict.fromkeys((signal.SIGINT, signal.SIGTERM), catch)
    if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        handlers[signal.SIGHUP] = catch
    if hasattr(signal, "SIGUSR1"):
        handlers[signal.SIGUSR1] = ask
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    try:
        yield caught
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
