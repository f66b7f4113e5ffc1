"""What is written and read by SDO: objects with values that they take, or that they should have."""

from collections.abc import Mapping

from canopen_twins.files.document import Item
from canopen_twins.scenario.actions import PATIENCE, Action, Download, Read, Write
from canopen_twins.scenario.reading.dry_run import DryRun
from canopen_twins.scenario.reading.payload import check_readable, check_writable, encode
from canopen_twins.scenario.reading.values import Told, wanted
from canopen_twins.scenario.schema import AnyStep
from canopen_twins.scenario.sdo_client import ACCEPTED
from canopen_twins.scenario.targets import Target
from canopen_twins.scenario.words import NONE

HIGHEST = 0xFFFF_FFFF


def write(told: Mapping[Item, Item], step: AnyStep, dry_run: DryRun) -> Action:
    """`{Run command: 1}`, `{0x1800:02: 253}`; with `abort` the one object is refused."""
    refused = _is_refused(step, "write")
    downloads = []
    for name, value in told.items():
        with name.problems.at(name):
            downloads.append(_download(name, value, dry_run, refused))
    return Write(tuple(downloads), _abort(step.abort), _timeout(step))


def read(told: Told, step: AnyStep, dry_run: DryRun) -> Action:
    """`{Actual voltage: {min: 5}}`, `{Firmware: any}`; with `abort` the one object is refused."""
    refused = _is_refused(step, "read")

    def find(name: Item) -> Target:
        if refused:
            return dry_run.targets.find_any(name)
        target = dry_run.targets.find(name)
        if target.variable is not None:
            check_readable(target.variable)
        return target

    return Read(wanted(told, find), _abort(step.abort), _timeout(step))


def _is_refused(step: AnyStep, verb: str) -> bool:
    objects = step.place.pairs[verb].value
    if step.abort is not None and len(objects.pairs) > 1:
        raise objects.wrong("one object at a time can be refused; make it several steps")
    return step.abort is not None


def _abort(code: Item | None) -> int | None:
    if code is None:
        return ACCEPTED
    return None if code.text == NONE else code.whole


def _timeout(step: AnyStep) -> float:
    return PATIENCE if step.timeout is None else step.timeout.seconds


def _download(name: Item, value: Item, dry_run: DryRun, refused: bool) -> Download:
    find = dry_run.targets.find_any if refused else dry_run.targets.find
    target = find(name)
    if target.variable is None:
        return Download(target, value.whole_up_to(HIGHEST).to_bytes(4, "little"), value.text)
    if not refused:
        check_writable(target.variable)
    return Download(target, encode(target.variable, value, not refused), value.text)
