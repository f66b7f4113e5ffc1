from collections.abc import Callable

import pytest

from canopen_twins import Bench
from canopen_twins.cli import main

CHANNEL = "can0"


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


@pytest.fixture
def field(tmp_path) -> Callable[..., object]:
    """The trace of a twin as the device, and of what a master does with it."""

    def trace(master, device="topcon", name="field.log", **settings):
        bench = Bench(device, node_id=5, **settings)
        master(bench)
        return log(tmp_path / name, bench.trace)

    return trace


def read(bench, *addresses):
    """SDO uploads, each followed through to its last segment."""
    for index, subindex in addresses:
        answers = bench.send(f"605#40{index & 0xFF:02X}{index >> 8:02X}{subindex:02X}00000000")
        toggle = 0
        while (answers and answers[-1].startswith("585#41")) or (toggle and not _last(answers)):
            answers = bench.send(f"605#{0x60 | toggle & 0x10:02X}00000000000000")
            toggle ^= 0x10
            toggle |= 1
        bench.run(0.01)


def _last(answers):
    return not answers or answers[-1].startswith("585#80") or int(answers[-1][4:6], 16) & 1


def write(bench, index, subindex, value, size=2):
    """An expedited SDO download."""
    command = 0x23 | (4 - size) << 2
    data = value.to_bytes(4, "little", signed=value < 0).hex().upper()
    bench.send(f"605#{command:02X}{index & 0xFF:02X}{index >> 8:02X}{subindex:02X}{data}")
    bench.run(0.01)
