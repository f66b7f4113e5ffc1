from collections.abc import Callable
from functools import cache

import pytest

from canopen_twins import Bench, devices
from canopen_twins.bus.clock import microseconds
from canopen_twins.cli import main
from canopen_twins.record.compare import Comparison


@pytest.fixture
def said(capsys):
    """Run a command in this process: its exit code and what it said on stdout and stderr."""

    def run(*arguments):
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as end:  # argparse's own way out
            code = end.code
        return code, *capsys.readouterr()

    return run


def log(path, records):
    """A trace as `candump -l` writes it."""
    path.write_text("".join(f"{record}\n" for record in records), "utf-8")
    return path


def traced(master, device="topcon", faults=(), live=None, **settings):
    """What is on the bus of a twin as the device, and of what a master does with it."""
    bench = Bench(device, **{"node_id": 5, **settings})
    for name, parameters in faults:
        bench.inject(name, **parameters)
    if live:
        bench.set(**live)
    master(bench)
    return bench.trace


def compared(records, device="topcon", tolerances=None, **settings):
    """What there is to say about a trace beside a twin."""
    twin = devices.create(device, **{"node_id": 5, **settings})
    comparison = Comparison({"twin": twin}, tolerances)
    for record in records:
        comparison.hear(microseconds(record.time), record.frame)
    return comparison.end()


def told(agreement):
    """The differences in a line each, without their frames."""
    return [f"{each.subject}: {each.kind}" for each in agreement.differences.values()]


@cache
def _lines(master, device, settings):
    """Of the trace of a twin as the device; several tests want that of the same one."""
    return tuple(map(str, traced(master, device, **dict(settings))))


@pytest.fixture
def field(tmp_path) -> Callable[..., object]:
    """The trace of a twin as the device, in a file."""

    def trace(master, device="topcon", name="field.log", **settings):
        return log(tmp_path / name, _lines(master, device, tuple(settings.items())))

    return trace
