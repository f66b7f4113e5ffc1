"""What a step can do, as the file has it, and how the answers to it are judged."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from canopen_twins.bus.frame import Frame
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.expected import Expected, ExpectedValues
from canopen_twins.scenario.matchers import Condition, Matcher
from canopen_twins.scenario.sdo_client import ACCEPTED, Answer, Transfer, download, upload
from canopen_twins.scenario.targets import Target
from canopen_twins.scenario.values import Wanted, value_of
from canopen_twins.scenario.verdict import Finding, Kind
from canopen_twins.slave.object import Abort


class Action:
    """What a step does; `str` says it in words."""

    def __str__(self) -> str:
        return type(self).__name__.lower()

    @property
    def expected(self) -> Expected | None:
        """What a diagnosis looks into where it does not come as it should."""
        return None


@dataclass(frozen=True)
class Wait(Action):
    """Nothing but its moment."""


# The plant, the supply, the bus


@dataclass(frozen=True)
class Set(Action):
    """Changes live settings and objects, as an operator or the plant would: all at once."""

    settings: Mapping[str, Any]


@dataclass(frozen=True)
class Send(Action):
    """Any frame, such as a SYNC, as a master."""

    frame: Frame


@dataclass(frozen=True)
class Nmt(Action):
    """A command of the NMT master to the node, by the node id it has by then."""

    command: int


@dataclass(frozen=True)
class Power(Action):
    """Switches the supply of the node; without effect if it is so already."""

    switch: Callable[[Node], None]


@dataclass(frozen=True)
class Limit(Action):
    """A bit rate for the bus; it is there before the first step, or never."""

    bit_rate: int

    def __str__(self) -> str:
        return f"bit rate of {self.bit_rate} bit/s"


@dataclass(frozen=True)
class RunMaster(Action):
    """The master of the file lives through it, from the first step on."""

    name: str

    def __str__(self) -> str:
        return f"master {self.name}"


@dataclass(frozen=True)
class Surroundings(Action):
    """What is around a run and no part of its file, in words: its command, its bus."""

    what: str

    def __str__(self) -> str:
        return self.what


@dataclass(frozen=True)
class Inject(Action):
    """Something goes wrong, in the order of the file, and perhaps ends by itself."""

    faults: Mapping[str, Mapping[str, Any]]
    lasts: float | Condition | None = None
    """Seconds, or what ends it; None: until it is cleared."""


@dataclass(frozen=True)
class Clear(Action):
    """A cause goes away; the device recovers as far as it does by itself."""

    fault: str | None
    """None for all of them."""


# SDO transfers as a master makes them

PATIENCE = 1.0  # seconds; CiA 301 leaves it open how long a client waits
NAMES = {abort.value: abort.name.lower().replace("_", " ") for abort in Abort}


@dataclass(frozen=True)
class Download:
    """One object, and the bytes for it."""

    target: Target
    data: bytes
    told: str
    """The value as the file has it."""


@dataclass(frozen=True)
class Write(Action):
    """Writes objects one after the other; what is refused ends the rest of the step."""

    downloads: tuple[Download, ...]
    abort: int | None = ACCEPTED
    """The code with which the master is refused; `ACCEPTED` if it is not, None for no answer."""
    timeout: float = PATIENCE
    """Seconds in which the answer to each request has to come."""

    def transfers(self) -> Sequence[Transfer]:
        """What is asked of the server, in its order."""
        return [
            download(each.target.address, each.data, each.target.variable is not None)
            for each in self.downloads
        ]

    def judge(self, answers: Sequence[Answer]) -> Finding | None:
        """What ends the step with the last of the answers so far; None: it goes on."""
        if answers[-1].code == self.abort == ACCEPTED:
            return None
        return _judged(self.downloads[len(answers) - 1].target, answers[-1], self.abort)

    def __str__(self) -> str:
        told = ", ".join(f"{each.target} = {each.told}" for each in self.downloads)
        return f"write {told}{_to_be(self.abort)}"


@dataclass(frozen=True)
class Read(Action):
    """Reads objects one after the other; another value than is wanted is a failure, and the end."""

    uploads: tuple[tuple[Target, Wanted], ...]
    abort: int | None = ACCEPTED
    """As for `Write`."""
    timeout: float = PATIENCE
    """As for `Write`."""

    @property
    def expected(self) -> Expected:
        """The values it reads."""
        return ExpectedValues([target.address for target, _ in self.uploads])

    def transfers(self) -> Sequence[Transfer]:
        """As for `Write`."""
        return [upload(target.address) for target, _ in self.uploads]

    def judge(self, answers: Sequence[Answer]) -> Finding | None:
        """As for `Write`; the last value tells all of them."""
        target, wanted = self.uploads[len(answers) - 1]
        if answers[-1].code != ACCEPTED or self.abort != ACCEPTED:
            return _judged(target, answers[-1], self.abort)
        fits = value_of(target, answers[-1].data) in wanted
        if fits and len(answers) < len(self.uploads):
            return None
        told = (
            f"{target} is {wanted.tell(value_of(target, answer.data))}"
            for (target, wanted), answer in zip(self.uploads, answers, strict=False)
        )
        return Finding(Kind.PASS if fits else Kind.FAIL, ", ".join(told))

    def __str__(self) -> str:
        told = ", ".join(f"{target} {wanted}" for target, wanted in self.uploads)
        return f"read {told}{_to_be(self.abort)}"


def _judged(target: Target, answer: Answer, expected: int | None) -> Finding:
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


# What the master and the nodes should do, or should not


@dataclass(frozen=True)
class Expectation(Action):
    """Something that is seen in a window that opens with the step.

    Whatever happens at that microsecond counts, before the step is carried out or after, but not
    what set the step off; so does what happens at the last one. Values of objects are looked at as
    they are when a microsecond is over.
    """

    matcher: Matcher
    within: float | None = None
    """Seconds; None: until `before` or the end of the run, for a value that is wanted: at once."""
    before: Condition | None = None
    """What ends the window, too."""
    never: bool = False
    """Whether it must not be seen."""

    @property
    def expected(self) -> Expected | None:
        """What its matcher is about."""
        return self.matcher.unwanted if self.never else self.matcher.expected

    @property
    def seconds(self) -> float | None:
        """How long the window is open at most; None: to the end of the run."""
        at_once = self.within is None and self.before is None and not self.never
        return 0.0 if at_once else self.within

    def __str__(self) -> str:
        before = f" before {self.before}" if self.before else ""
        if self.never:
            return f"no {self.matcher}{before}{_time(self.within, 'for')}"
        within = _time(self.seconds, "within") if self.seconds != 0 else " at once"
        return f"{self.matcher}{within}{before}"


def _time(seconds: float | None, preposition: str) -> str:
    return "" if seconds is None else f" {preposition} {seconds:g} s"
