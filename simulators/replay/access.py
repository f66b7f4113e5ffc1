"""What a step does by SDO, as a master would: it writes objects."""

from dataclasses import dataclass

from simulators.objects import Abort
from simulators.replay.master import ACCEPTED
from simulators.replay.scenario import Action, Stage
from simulators.replay.targets import Target
from simulators.replay.verdict import Finding, Kind

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
    """Writes objects one after the other, each with one request."""

    downloads: tuple[Download, ...]
    abort: int
    """The code with which the master is refused; `ACCEPTED` if it is not."""

    def carry_out(self, stage: Stage) -> None:
        """What is refused ends the rest of the step."""
        for each in self.downloads:
            node_id, target = stage.node.node_id, each.target
            sized = target.variable is not None
            code = stage.master.download(node_id, target.address, each.data, sized)
            if code != self.abort or code != ACCEPTED:
                stage.report(self._finding(each, code))
                return

    def _finding(self, download: Download, code: int | None) -> Finding:
        seen = f"{download.target} is {_answer(code)}"
        if code == self.abort:
            return Finding(Kind.PASS, seen)
        return Finding(Kind.FAIL if self.abort else Kind.ERROR, seen)

    def __str__(self) -> str:
        told = ", ".join(f"{each.target} = {each.told}" for each in self.downloads)
        return f"write {told}{f' to be {_answer(self.abort)}' if self.abort else ''}"


def _answer(code: int | None) -> str:
    if code is None:
        return "not answered"
    if code == ACCEPTED:
        return "accepted"
    name = NAMES.get(code)
    return f"refused with {code:#010x}{f' ({name})' if name else ''}"
