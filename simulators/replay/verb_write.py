"""The verb `write`: objects are written by SDO, as a master would."""

from simulators.documents.document import Item, Pair
from simulators.replay.access import Download, Write
from simulators.replay.payload import check_access, encode
from simulators.replay.rehearsal import Rehearsal
from simulators.replay.scenario import Action
from simulators.replay.sdo import ACCEPTED

HIGHEST_CODE = 0xFFFFFFFF


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
