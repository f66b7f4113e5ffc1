"""PDOs as a slave has them: their records, read by SDO."""

from collections.abc import Collection, Iterator

from canopen_twins.bus import identifiers
from canopen_twins.conform.tester import SILENCE, Failed, Tester

RPDOS, TPDOS = range(0x1400, 0x1600), range(0x1800, 0x1A00)


def records(tester: Tester, area: range) -> list[int]:
    """The communication records that the dictionary has."""
    return [index for index in area if tester.entry(index, 1) is not None]


def valid(tester: Tester, area: range) -> Iterator[tuple[int, int]]:
    """Those that are in force now, with their identifiers."""
    for index in records(tester, area):
        can_id = identifiers.of_cob_id(tester.number(index, 1))
        if can_id is not None:
            yield index, can_id


def sent_ids(tester: Tester) -> Collection[int]:
    """The identifiers of the TPDOs in force."""
    return {can_id for _, can_id in valid(tester, TPDOS)}


def expect_none(tester: Tester, can_ids: Collection[int], when: str) -> None:
    """None of some TPDOs is sent, whether there is SYNC or it is asked for.

    Raises:
        Failed: one is.
    """
    tester.forget()
    tester.send(identifiers.SYNC)
    for can_id in can_ids:
        tester.send(can_id, remote=True)
    for frame in tester.listen(SILENCE):
        if frame.can_id in can_ids and not frame.remote:
            raise Failed(f"{frame} is sent {when}")
