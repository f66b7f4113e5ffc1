"""Runs the benchmarks a few times and writes docs/performance.md: `python -m benchmarks.report`.

The ratio of a figure is taken within each run, where twin and peer met the same machine in the
same mood; the report gives the median of the runs, and the lowest and the highest of them.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.figures import SECTIONS, Figure, Goal
from benchmarks.notes import NOTES

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "performance.md"
HEAD = """# Performance

Written by `python -m benchmarks.report`; what each line measures is in `benchmarks/`.

A ratio says how many times as fast the twin is as its peer, measured in the same run. There were
{runs} runs: each ratio is the median of theirs, in brackets the lowest and the highest; times are
medians too. The peer is `canopen.LocalNode` as shipped, with the EDS of the TopCon: it answers from
memory, has neither NMT states nor PDOs, and no device behind it. The twin is a TopCon with its
output stage.

Machine: {cores} x {cpu}, Python {python}, canopen {canopen}, python-can {can}.
Nothing was done to keep other work off it: that is what medians and ranges are for.
"""
BY_HAND = "## While somebody looks"  # from there on the page is kept: it takes a browser
COLUMNS = ("", "ratio", "goal", "reached", "twin", "peer")
UNITS = {"s": 1.0, "ms": 1e-3, "µs": 1e-6}

Times = Mapping[str, float]
"""Median of each benchmark of one run, in seconds."""


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5, help="of all benchmarks (default: 5)")
    runs = [measure() for _ in range(parser.parse_args().runs)]
    PAGE.write_text(page(runs), "utf-8")
    print(PAGE.read_text("utf-8"))


def measure() -> dict[str, Any]:
    """One run, as pytest-benchmark saves it."""
    with tempfile.TemporaryDirectory() as folder:
        saved = Path(folder) / "run.json"
        options = ["-q", "--benchmark-max-time=0.5", f"--benchmark-json={saved}"]
        command = [sys.executable, "-m", "pytest", "benchmarks", *options]
        subprocess.run(command, cwd=ROOT, check=True)
        content: dict[str, Any] = json.loads(saved.read_text("utf-8"))
        return content


def page(runs: list[dict[str, Any]]) -> str:
    """The whole document."""
    machine = runs[0]["machine_info"]
    head = HEAD.format(
        runs=len(runs),
        cores=machine["cpu"]["count"],
        cpu=machine["cpu"]["brand_raw"],
        python=machine["python_version"],
        canopen=machine["packages"]["canopen"],
        can=machine["packages"]["python-can"],
    )
    times = [{test["name"]: test["stats"]["median"] for test in run["benchmarks"]} for run in runs]
    kept = "".join(PAGE.read_text("utf-8").partition(BY_HAND)[1:])
    return "\n".join([head, *tables(times), kept])


def tables(runs: Sequence[Times]) -> Iterator[str]:
    """A table for each section, ratios first."""
    for section, figures in SECTIONS.items():
        yield f"## {section}\n\n{NOTES[section]}\n"
        yield row(*COLUMNS)
        yield row("---", *("---:",) * 5)
        yield from (row(*cells(figure, runs)) for figure in figures)
        yield ""


def row(*cells: str) -> str:
    """One line of a table."""
    return f"| {' | '.join(cells)} |"


def cells(figure: Figure, runs: Sequence[Times]) -> Iterator[str]:
    """What the report says of a figure."""
    twins = [run[figure.twin] for run in runs]
    peers = [run[figure.peer] if isinstance(figure.peer, str) else figure.peer for run in runs]
    ratios = [peer / twin for peer, twin in zip(peers, twins, strict=True)]
    ratio, twin, peer = median(ratios), median(twins), median(peers)
    yield figure.what
    yield f"**{number(ratio)}** ({number(min(ratios))}..{number(max(ratios))})"
    yield goal(figure.goal)
    yield {None: "", True: "yes", False: "no"}[reached(figure.goal, ratio, twin)]
    yield duration(twin)
    yield f"{duration(peer)}, {figure.against}"


def goal(aim: Goal) -> str:
    """In words."""
    ratio = None if aim.ratio is None else f"at least {number(aim.ratio)}"
    time = None if aim.time is None else f"at most {duration(aim.time)}"
    return ", ".join(part for part in (ratio, time) if part)


def reached(aim: Goal, ratio: float, time: float) -> bool | None:
    """Whether a goal is, None if there is none."""
    if aim == Goal():
        return None
    return (aim.ratio is None or ratio >= aim.ratio) and (aim.time is None or time <= aim.time)


def number(value: float) -> str:
    """With two digits that count."""
    return f"{float(f'{value:.2g}'):,g}"


def duration(seconds: float) -> str:
    """With the unit that suits it."""
    name, size = next(
        ((name, size) for name, size in UNITS.items() if seconds >= size), ("µs", 1e-6)
    )
    return f"{seconds / size:.3g} {name}" if seconds < 1000 else f"{seconds:.0f} s"


if __name__ == "__main__":
    main()
