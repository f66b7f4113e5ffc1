"""Plays the scenarios and writes docs/coverage.md: `python -m tools.report`."""

from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from tools.proofs import Proof, proofs, shipped
from tools.rows import Row, faults, faults_of_all, messages, stories

PAGE = Path(__file__).parent.parent / "docs" / "coverage.md"
HEAD = """# What the scenarios prove

Written by `python -m tools.report`, which plays every scenario that is shipped. A message
counts for a scenario that expects it, by its fields or by the value of its object, and gets it (a
bit has to go again, too); a fault for one that lets it happen and gets something that it expects
after that; a story for one that names its statement under `covers` and passes. A test keeps this
page true, and no line of it without a scenario.
"""
SCENARIOS = "../scenarios"


class Section(NamedTuple):
    """A table of the page."""

    title: str
    rows: tuple[Row, ...]


def main() -> None:
    """Play and write."""
    tables, played = list(sections()), proofs()
    missing = list(unproven(tables, played))
    PAGE.write_text(page(tables, played), "utf-8")
    print(
        f"{PAGE}: {len(played)} scenarios, {len(missing)} lines without one", *missing, sep="\n  "
    )


def sections() -> Iterator[Section]:
    """All tables."""
    for device in shipped():
        yield Section(f"{device}: stories", tuple(stories(device)))
        yield Section(f"{device}: messages", tuple(messages(device)))
        yield Section(f"{device}: faults", tuple(faults(device)))
    yield Section("Faults of every device", tuple(faults_of_all()))


def unproven(tables: Iterable[Section], played: Collection[Proof]) -> Iterator[str]:
    """The lines without a scenario."""
    for section in tables:
        for row in section.rows:
            if not any(map(row.proven, played)):
                yield f"{section.title}: {row.name} {row.text}"


def page(tables: Iterable[Section], played: Collection[Proof]) -> str:
    """The whole document."""
    return "\n".join([HEAD, *(_table(each, played) for each in tables if each.rows)])


def _table(section: Section, played: Collection[Proof]) -> str:
    lines = [_line("", "what", "scenarios"), _line("---", "---", "---")]
    lines += [_line(row.name, row.text, _links(row, played)) for row in section.rows]
    return "\n".join([f"## {section.title}\n", *lines, ""])


def _line(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def _links(row: Row, played: Collection[Proof]) -> str:
    names = [proof.file.removesuffix(".yaml") for proof in played if row.proven(proof)]
    return ", ".join(f"[{name}]({SCENARIOS}/{name}.yaml)" for name in names)


if __name__ == "__main__":
    main()
