"""A find: a scenario file that fails in the same way in every process, with a note in words."""

from __future__ import annotations

import os
import pickle
import secrets
import subprocess
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import Any

from canopen_twins.errors import UserError
from canopen_twins.files.whole import write_whole
from canopen_twins.hunt.contract import Contract, Disturbance, Plan, what
from canopen_twins.hunt.run import (
    COMMAND,
    ENDED,
    MASTER,
    Failure,
    Result,
    difference,
    run_to_compare,
)
from canopen_twins.scenario import Kind, Outcome, Verdict

SUFFIX = ".twin.yaml"
TRIAL = ".yaml"  # which neither pytest nor another hunt takes for a find
PATIENCE = 120.0  # seconds of real time for another process
OTHER_HASH_SEED = "4711"  # the order of sets of texts is another there
MARK = b"\nresult: "  # comes after whatever else has been written there


@dataclass(frozen=True)
class Find:
    """What has been found: a failure, and the file that shows it."""

    failure: Failure
    file: Path
    plan: Plan
    verdict: Verdict
    steps: int
    """Of the contract, those that matter."""
    text: str
    """Of the file."""

    @property
    def outcome(self) -> Outcome:
        """What failed."""
        return _failed(self.verdict, self.failure)


def _failed(verdict: Verdict, failure: Failure) -> Outcome:
    failed = [each for each in verdict.outcomes if each.kind is Kind.FAIL]
    named = [each for each in verdict.outcomes if failure.what.startswith(each.what)]
    bad = [each for each in named if each.kind in (Kind.FAIL, Kind.ERROR)]
    return min(bad or failed, key=lambda each: each.time)


def note_of(verdict: Verdict, failure: Failure, plan: Plan, whereabouts: str = "") -> str:
    """What happened, who waited for what, and why, as far as somebody knows."""
    outcome = _failed(verdict, failure)
    order = [f"the nodes stand in the order {', '.join(plan.order)}"] if plan.order else []
    if plan.arbitration:
        who = "the lowest identifier" if plan.arbitration == "identifier" else plan.arbitration
        order.append(f"of the frames of one microsecond {who} is first")
    different = [*map(_words, plan.disturbances), *map(_delivered, plan.settings), *order]
    wrong = "; ".join(different)
    is_master = outcome.what.startswith((MASTER, COMMAND))
    expected = "" if is_master else f" Expected: {outcome.what}."
    told = f"{_sentence(wrong) or 'Nothing goes wrong'}.{expected}"
    seen = f"At {outcome.time:.6g} s{' the master:' if is_master else ''} {outcome.seen}."
    if outcome.seen.startswith(ENDED):  # nobody knows when
        seen = f"The master {outcome.seen}. Whoever plays this file ends with it."
    reasons = [line.strip() for line in outcome.scene.splitlines() if "why: " in line]
    why = f" {_sentence(reasons[-1].partition('why: ')[2])}." if reasons else ""
    at = f" The master waits in {whereabouts}." if whereabouts else ""
    return f"{told} {seen}{why}{at}"


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


WORDS = {
    "write": "the master writes {}",
    "nmt": "the master commands {}",
    "emcy": "it sends EMCY {}",
    "state": "it becomes {}",
}
"""Of the moments that a hunt knows."""


def _words(told: Disturbance) -> str:
    when = f"at {told['at']:g} s" if "at" in told else f"when {_condition(told['when'])}"
    lasts = f" for {told['for']:g} s" if "for" in told else ""
    node = f" of {told['node']}" if "node" in told else ""
    if "set" in told:
        return f"set {_named(told['set'])}{node} {when}"
    inject = told["inject"]
    name = what(told)
    given = "" if isinstance(inject, str) else f" ({_named(inject[name])})"
    return f"the fault {name}{given}{node} {when}{lasts}"


def _condition(when: Mapping[str, Any]) -> str:
    kind = next(key for key in WORDS if key in when)
    value, nth = when[kind], when.get("nth", 1)
    told = WORDS[kind].format(_named(value) if isinstance(value, Mapping) else value)
    return told if nth == 1 else f"{told}, for the {nth}. time"


def _named(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} {value}" for key, value in values.items())


def _delivered(setting: tuple[str, str, Any]) -> str:
    node, key, value = setting
    return f"{node} is delivered with {key} {value}"


Play = Callable[[Contract, Plan], Result]
"""One run, with its frames."""


class NotTheSameError(Exception):
    """A find that has not come again in the same way; the message tells the first difference."""


def write_find(  # noqa: PLR0913 - who asks for it knows all of that
    contract: Contract,
    result: Result,
    failure: Failure,
    folder: Path,
    play: Play,
    *,
    before: Find | None = None,
) -> Find:
    """Write the file, if it fails in the same way there and in another process.

    Args:
        contract: What was played.
        result: Of the run that has failed, with its frames.
        failure: What is to come again.
        folder: Where the file is to lie.
        play: Plays the file.
        before: Whose file it replaces; None: it takes the next free name.

    Raises:
        NotTheSameError: it fails in another way there, or not at all.
        UserError: it cannot be written.
    """
    assert result.verdict is not None
    trial = Trial(contract, folder, _text(contract, result, failure, folder))
    try:
        if contract.command or result.death:  # in real time no two runs are the same
            trial.fail(failure, play)
        else:
            trial.repeat(result, play)
        path = trial.keep(None if before is None else before.file)
    except OSError as error:
        raise UserError(f"a find cannot be written to {folder}: {error.strerror}") from error
    finally:
        trial.path.unlink(missing_ok=True)
    steps = contract.parts - len(result.plan.left_out)
    return Find(failure, path, result.plan, result.verdict, steps, trial.text)


def _text(contract: Contract, result: Result, failure: Failure, folder: Path) -> str:
    """Of the file, with what has happened in words."""
    assert result.verdict is not None
    whereabouts = dict(zip(result.failures, result.whereabouts, strict=True)).get(failure, "")
    named: dict[str, object] = {
        "name": f"{result.verdict.name}: {', '.join(result.plan.faults) or 'without any fault'}",
        "note": note_of(result.verdict, failure, result.plan, whereabouts),
    }
    return contract.text(result.plan, named, folder)


class Trial:
    """A file that may become a find; what fails otherwise has no name yet.

    Before each use it is written anew: a master may have deleted it, and its folder.
    """

    def __init__(self, contract: Contract, folder: Path, text: str) -> None:
        self.path = folder / f".{secrets.token_hex(8)}{TRIAL}"
        self.text = text
        self._contract = contract
        self._folder = folder

    def fail(self, failure: Failure, play: Play) -> None:
        """Raises `NotTheSameError` if it does not fail so."""
        if failure not in self._played(play).failures:
            raise NotTheSameError("it has not failed again")

    def repeat(self, result: Result, play: Play) -> None:
        """Raises `NotTheSameError` if it is another run than that, here or in another process."""
        here = self._played(play)
        _expect_the_same(result, here, "two runs of it differ")
        self._write()
        there = in_another_process(self.path, self._contract.master)
        _expect_the_same(here, there, "a run in another process differs")

    def keep(self, place: Path | None) -> Path:
        """Give it the name of a file that it replaces, or one of its own; what that is."""
        self._write()
        return self.path.replace(place or _free_name(self._folder))

    def _played(self, play: Play) -> Result:
        self._write()
        return play(replace(self._contract, file=self.path), Plan())

    def _write(self) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)
        write_whole(self.path, self.text)


def _free_name(folder: Path) -> Path:
    """One that is ours from now on: another hunt in this folder takes the next."""
    for path in (folder / f"hunt-{n}{SUFFIX}" for n in count(1)):
        with suppress(FileExistsError):
            path.touch(exist_ok=False)
            return path
    raise AssertionError  # there is always another number


def _expect_the_same(one: Result, other: Result, told: str) -> None:
    """Raises `NotTheSameError` if they are not."""
    if where := difference(one, other):
        raise NotTheSameError(f"{told}: {where}")


def in_another_process(path: Path, master: str) -> Result:
    """What a run of a file is there, where sets have another order."""
    environment = {
        **os.environ,
        "PYTHONHASHSEED": OTHER_HASH_SEED,
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
    }
    command = [sys.executable, "-m", __name__, str(path), master]
    try:
        done = subprocess.run(
            command, capture_output=True, env=environment, timeout=PATIENCE, check=False
        )
    except subprocess.TimeoutExpired:
        return Result(Plan(), error=f"no end in {PATIENCE:g} s of real time")
    if done.returncode:
        return Result(Plan(), error=f"its process has ended with {done.returncode}")
    told: Result = pickle.loads(done.stdout[done.stdout.index(MARK) + len(MARK) :])
    return told


def _main(path: str, master: str) -> None:
    result = run_to_compare(Contract(Path(path), master), Plan())
    sys.stdout.buffer.write(MARK + pickle.dumps(result))


if __name__ == "__main__":
    _main(*sys.argv[1:])
