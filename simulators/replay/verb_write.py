"""The verb `write`: objects are written by SDO, as a master would."""

from dataclasses import dataclass

from simulators.documents.document import Item, Pair
from simulators.objects import Abort
from simulators.replay.master import ACCEPTED
from simulators.replay.payload import check_access, encode
from simulators.replay.rehearsal import Rehearsal
from simulators.replay.scenario import Action, Stage
from simulators.replay.targets import Target
from simulators.replay.verdict import Finding, Kind

HIGHEST_CODE = 0xFFFFFFFF
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


def parse_write(item: Item, rehearsal: Rehearsal, abort: Item | None = None) -> Action:
    """`{Run command: 1}`, `{0x1800:02: 253}`; with `abort` the one object is refused."""
    code = ACCEPTED if abort is None else abort.whole_up_to(HIGHEST_CODE)
    if abort is not None and code == ACCEPTED:
        raise abort.wrong(f"{abort.text} is no abort code; they look like 0x06090030")
    if code and len(item.pairs) > 1:
        raise item.wrong("one object at a time can be refused; make it several steps")
    return Write(tuple(_downloads(item, rehearsal, bool(code))), code)


def _downloads(item: Item, rehearsal: Rehearsal, refused: bool) -> list[Download]:
    downloads = []
    for pair in item.some_pairs.values():
        with item.problems.at(pair.key):
            downloads.append(_download(pair, rehearsal, refused))
    return downloads


def _download(pair: Pair, rehearsal: Rehearsal, refused: bool) -> Download:
    find = rehearsal.targets.find_any if refused else rehearsal.targets.find
    target = find(pair.key)
    if target.variable is None:
        data = pair.value.whole_up_to(HIGHEST_CODE).to_bytes(4, "little")
        return Download(target, data, pair.value.text)
    if not refused:
        check_access(target.variable)
    return Download(target, encode(target.variable, pair.value, not refused), pair.value.text)
