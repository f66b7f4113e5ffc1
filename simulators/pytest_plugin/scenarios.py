"""`*.twin.yaml` as tests, and verdicts as pytest tells them.

A scenario is played in the set-up of its test. What it says of who is tested is the outcome of the
test itself; that it could not be carried out is an error, and one in the set-up is what pytest and
CI tell apart from a failure.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from simulators.errors import UserError
from simulators.pytest_plugin.fixtures import TOLD

if TYPE_CHECKING:
    from simulators.replay import Scenario, Verdict


def read(name: str) -> Scenario:
    """A scenario of a file, told by its path from here, or one that is shipped.

    Raises:
        UserError: there is neither, or something is wrong with it.
    """
    from simulators.commands.scenarios import load  # noqa: PLC0415

    here = Path.cwd()
    return load(str(Path(name).relative_to(here)) if Path(name).is_relative_to(here) else name)


def beside(test: Path, name: str) -> Scenario:
    """The scenario a test asks for; fails it if there is none, or something is wrong with it."""
    file = test.parent / name
    try:
        return read(str(file) if file.exists() else name)
    except UserError as mistakes:
        told = str(mistakes)
    pytest.fail(told, pytrace=False)


def judge(verdicts: Iterable[Verdict]) -> None:
    """Raises what pytest takes for a failure, or else for a skipped test; nothing for PASS."""
    from simulators.replay import Kind  # noqa: PLC0415

    bad = [verdict for verdict in verdicts if verdict.kind is not Kind.PASS]
    if failed := [str(verdict) for verdict in bad if not verdict.ok]:
        pytest.fail("\n".join(failed), pytrace=False)
    for verdict in bad:
        skipped = next(each for each in verdict.outcomes if each.kind is Kind.SKIP)
        pytest.skip(f"{verdict.file}:{skipped.line}: {skipped.seen}")


def settle(item: pytest.Item) -> None:
    """Play the rest of the scenarios of a test, note what came of them, and judge them."""
    if TOLD not in item.stash:
        return
    for bench in item.stash[TOLD]:
        bench.finish()
    note(item)
    verdicts = [bench.verdict for bench in item.stash[TOLD]]
    del item.stash[TOLD]
    judge(verdicts)


def note(item: pytest.Item) -> None:
    """Keep the verdicts of a test so far as its properties, for `--junitxml` and others."""
    for bench in item.stash.get(TOLD, []):
        keep(item, bench.verdict)


def keep(item: pytest.Item, verdict: Verdict) -> None:
    """The same with one of them."""
    from simulators.verdicts.properties import properties  # noqa: PLC0415

    item.user_properties.extend(properties(verdict))


class ScenarioFile(pytest.File):
    """A file with one scenario, which is one test."""

    def collect(self) -> Iterable[pytest.Item]:
        """The test; raises `CollectError` with a line for everything that is wrong."""
        try:
            scenario = read(str(self.path))
        except UserError as mistakes:
            raise self.CollectError(str(mistakes)) from None
        name = " ".join(scenario.name.split()).replace("::", ":")  # two would split node ids
        yield ScenarioItem.from_parent(self, name=name or self.path.stem, scenario=scenario)


class ScenarioItem(pytest.Item):
    """One scenario; `-k` finds it by its name, its file, its nodes and what it covers."""

    verdict: Verdict

    def __init__(self, *, scenario: Scenario, **described: object) -> None:
        super().__init__(**described)  # type: ignore[arg-type]
        self.scenario = scenario
        self.extra_keyword_matches.update(scenario.nodes, scenario.covers)

    def setup(self) -> None:
        """Play it; raises if it could not be carried out."""
        from simulators.replay import Kind, play  # noqa: PLC0415

        self.verdict = play(self.scenario)
        keep(self, self.verdict)
        if self.verdict.kind is not Kind.FAIL:
            judge([self.verdict])

    def runtest(self) -> None:
        """Raises if something else has come than was expected."""
        judge([self.verdict])

    def reportinfo(self) -> tuple[Path, int, str]:
        """Where it is, for the headings of reports."""
        return self.path, 0, self.name
