"""Mistakes that real masters make, each put into a reference master: a hunt has to find them.

A mutant differs from its master in nothing but its mistake.
"""

import shutil
from dataclasses import dataclass
from pathlib import Path
from textwrap import indent

import yaml

from canopen_twins.hunt.search import Budget, Report

HERE = Path(__file__).parent
EXAMPLES = HERE.parents[2] / "docs" / "examples" / "masters"
DEVICES = ("topcon", "charger", "gateway")
DEPTHS = [" " * columns for columns in (20, 16, 12, 8, 4, 0)]


@dataclass(frozen=True)
class Mutant:
    """A mistake in one of the masters, and what makes it: pieces of text, and what replaces them.

    A piece of whole lines stands there at whatever depth.
    """

    device: str
    name: str
    mistake: str
    instead: tuple[tuple[str, str], ...]

    def __str__(self) -> str:
        return f"{self.device}: {self.name}"

    @property
    def text(self) -> str:
        """The whole of the master."""
        text = (EXAMPLES / f"{self.device}_master.py").read_text("utf-8")
        for correct, wrong in self.instead:
            depth = next((each for each in DEPTHS if indent(correct, each) in text), None)
            assert depth is not None, f"{self}: {correct!r} stands there no more"
            assert text.count(indent(correct, depth)) == 1, (
                f"{self}: {correct!r} stands there twice"
            )
            text = text.replace(indent(correct, depth), indent(wrong, depth))
        return text

    def put_into(self, folder: Path) -> Path:
        """It lies there under the name of its master, beside the contract, which is returned."""
        (folder / f"{self.device}_master.py").write_text(self.text, "utf-8")
        return Path(shutil.copy(EXAMPLES / f"{self.device}_contract.yaml", folder))


def mutants() -> list[Mutant]:
    """All of them, by device."""
    return [
        Mutant(
            device,
            row["name"],
            row["mistake"],
            tuple((piece["of"], piece["put"]) for piece in row["instead"]),
        )
        for device in DEVICES
        for row in yaml.safe_load((HERE / f"{device}.yaml").read_text("utf-8"))
    ]


class UntilFound(Budget):
    """Not a run more when something has been found."""

    report: Report | None = None

    def left(self, runs: int) -> bool:
        """Whether to go on."""
        return super().left(runs) and not (self.report and self.report.finds)
