"""What people hear of a run: what happens, with --words; how the twins are, when SIGUSR1 asks."""

from __future__ import annotations

import argparse
import sys
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Record, Segment
from canopen_twins.cli.command import Parser, Signals
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.report import SHOWN, device_report

if TYPE_CHECKING:
    from canopen_twins.record.trace import Observer


def add_words(parser: Parser) -> None:
    """--words."""
    text = "print what happens: frames in words, refusals, states; -q leaves usual frames out"
    parser.add_argument("--words", dest="tells", action="store_true", help=text)


class Telling(NamedTuple):
    """What prints a run."""

    observers: Sequence[Observer] = ()
    """Who has to hear of it."""
    start: Callable[[], None] = lambda: None
    """To be called when the twins are on the bus."""


@contextmanager
def telling(options: argparse.Namespace) -> Iterator[Telling]:
    """What prints a run, if that is wanted; where stdout is for a program, on stderr."""
    if not options.tells:
        yield Telling()
        return
    # what a scenario expects has words, too: a run that tells nothing starts without scenarios
    from canopen_twins.cli.words import Printer, Words, is_coloured  # noqa: PLC0415

    stream = sys.stderr if options.json else sys.stdout
    printer = Printer(stream)
    try:
        told = Words(printer.put, is_coloured(stream), options.quiet)
        yield Telling((told.attach,), printer.start)
    finally:
        printer.close()


class StateOnDemand:
    """How the twins are, on stderr, when SIGUSR1 has come: between two frames, not half-way."""

    def __init__(self, segment: Segment[Node], signals: Signals) -> None:
        self._nodes = segment.nodes
        self._segment = segment
        self._signals = signals
        self._records: deque[Record] = deque(maxlen=SHOWN)
        segment.listeners.append(self._hear)

    def tell_if_asked(self) -> None:
        """Tell it, if somebody has asked since."""
        if self._signals.asks_for_state:
            self._signals.asks_for_state = False
            told = [device_report(node, list(self._records)) for node in self._nodes]
            lines = [f"{self._segment.clock.now:.6f} s", *told]
            print("\n".join(lines), file=sys.stderr, flush=True)

    def _hear(self, frame: Frame, sender: str) -> None:
        self._records.append(Record(self._segment.clock.now, frame, sender))
