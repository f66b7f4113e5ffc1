"""What a step does by SDO, as a master would: it writes and reads objects."""

from collections.abc import Sequence
from dataclasses import dataclass

from canopen_twins.scenario.context import Context
from canopen_twins.scenario.matchers import Wanted
from canopen_twins.scenario.scenario import Action
from canopen_twins.scenario.sdo import ACCEPTED, Answer, download, upload
from canopen_twins.scenario.targets import Target
from canopen_twins.scenario.values import value_of
from canopen_twins.scenario.verdict import Finding, Kind
from canopen_twins.slave.object import Abort, Address

NAMES = {abort.value: abort.name.lower().replace("_", " ") for abort in Abort}
PATIENCE = 1.0  # seconds; CiA 301 leaves it open how long a client waits


@dataclass(frozen=True)
class Download:
    """One object, and the bytes for it."""

    target: Target
    data: bytes
    told: str
    """The value as the file has it."""


@dataclass(frozen=True)
class Write(Action):
    """Writes objects one after the other."""

    downloads: tuple[Download, ...]
    abort: int | None = ACCEPTED
    """The code with which the master is refused; `ACCEPTED` if it is not, None for no answer."""
    timeout: float = PATIENCE
    """Seconds in which the answer to each request has to come."""

    def carry_out(self, context: Context) -> None:
        """What is refused ends the rest of the step."""
        transfers = [
            download(each.target.address, each.data, each.target.variable is not None)
            for each in self.downloads
        ]

        def answered(number: int, answer: Answer) -> bool:
            if answer.code == self.abort == ACCEPTED:
                return True
            context.report(judged(self.downloads[number].target, answer, self.abort))
            return False

        context.ask(transfers, self.timeout, answered)

    def __str__(self) -> str:
        told = ", ".join(f"{each.target} = {each.told}" for each in self.downloads)
        return f"write {told}{_to_be(self.abort)}"


@dataclass(frozen=True)
class Read(Action):
    """Reads objects one after the other; another value than is wanted is a failure."""

    uploads: tuple[tuple[Target, Wanted], ...]
    abort: int | None = ACCEPTED
    """As for `Write`."""
    timeout: float = PATIENCE
    """As for `Write`."""

    @property
    def about(self) -> Sequence[Address]:
        """What it reads."""
        return [target.address for target, _ in self.uploads]

    def carry_out(self, context: Context) -> None:
        """What is refused or another value ends the rest of the step; else all is told."""
        told: list[str] = []

        def answered(number: int, answer: Answer) -> bool:
            target, wanted = self.uploads[number]
            if answer.code != ACCEPTED or self.abort != ACCEPTED:
                context.report(judged(target, answer, self.abort))
                return False
            value = value_of(target, answer.data)
            told.append(f"{target} is {wanted.tell(value)}")
            fits = value in wanted
            if not fits or len(told) == len(self.uploads):
                context.report(Finding(Kind.PASS if fits else Kind.FAIL, ", ".join(told)))
            return fits

        transfers = [upload(target.address) for target, _ in self.uploads]
        context.ask(transfers, self.timeout, answered)

    def __str__(self) -> str:
        told = ", ".join(f"{target} {wanted}" for target, wanted in self.uploads)
        return f"read {told}{_to_be(self.abort)}"


def judged(target: Target, answer: Answer, expected: int | None) -> Finding:
    """What an answer means where another one, or none, may have been expected."""
    seen = f"{target} is {_answer(answer.code)}"
    if answer.by_client:
        return Finding(Kind.ERROR, f"{target} is answered with what is no answer to the request")
    if answer.code == expected:
        return Finding(Kind.PASS, seen)
    return Finding(Kind.ERROR if expected == ACCEPTED else Kind.FAIL, seen)


def _to_be(expected: int | None) -> str:
    return "" if expected == ACCEPTED else f" to be {_answer(expected)}"


def _answer(code: int | None) -> str:
    if code is None:
        return "not answered"
    if code == ACCEPTED:
        return "accepted"
    name = NAMES.get(code)
    return f"refused with {code:#010x}{f' ({name})' if name else ''}"
