"""What a comparison has found: how often both agree, and the first difference of each kind."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from math import ceil
from typing import NamedTuple


class Kind(StrEnum):
    """In what a device and its twin differ."""

    VALUE = "another value"
    CODE = "another abort code"
    REFUSAL = "refused by one, not by the other"
    FORM = "another form"
    LACKS = "only the twin sends it"
    MORE = "only the device sends it"
    TIME = "another time"


ALONE = (Kind.LACKS, Kind.MORE)
"""Those of which a line that was lost may be the reason."""


class Subject(NamedTuple):
    """What something is told of."""

    node: str
    service: str
    """SDO, TPDO1, heartbeat and the like."""
    object: str = ""
    """Its address and name; empty where the service is all there is to say."""

    def __str__(self) -> str:
        return f"{self.service} {self.object}".strip()


class Account(NamedTuple):
    """A difference as it is explained."""

    text: str
    device: Sequence[str] = ()
    """Frames of the trace, in words."""
    twin: Sequence[str] = ()
    why: Sequence[str] = ()
    """What the twin has to say of it."""


@dataclass
class Difference:
    """The first of its kind, and how often it came."""

    subject: Subject
    kind: Kind
    tick: int
    """Microseconds from the first frame of the trace on."""
    account: Account
    count: int = 1


@dataclass
class Row:
    """How often both agree in something, and how often not."""

    agreed: int = 0
    differed: int = 0

    @property
    def total(self) -> int:
        """How often it was compared."""
        return self.agreed + self.differed

    @property
    def share(self) -> float:
        """From 0 to 1."""
        return self.agreed / self.total if self.total else 1.0


@dataclass
class Agreement:
    """Filled while a trace is played; `on_new` hears of the first difference of each kind."""

    rows: dict[Subject, Row] = field(default_factory=dict)
    differences: dict[tuple[Subject, Kind], Difference] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)
    """What was done to follow the trace, in words."""
    unexercised: dict[str, list[str]] = field(default_factory=dict)
    """What the trace has not shown of each node, in words."""
    on_new: Callable[[Difference], None] = lambda difference: None

    def agree(self, subject: Subject) -> None:
        """Once more it was the same."""
        self._row(subject).agreed += 1

    def differ(
        self,
        row: Subject,
        kind: Kind,
        tick: int,
        account: Callable[[], Account],
        about: Subject | None = None,
    ) -> None:
        """Once more it was not; `about` is what of the row it is, such as one object of a PDO."""
        self._row(row).differed += 1
        self.tell(about or row, kind, tick, account)

    def tell(self, about: Subject, kind: Kind, tick: int, account: Callable[[], Account]) -> None:
        """Explain the first of its kind, count the others."""
        key = (about, kind)
        if (known := self.differences.get(key)) is not None:
            known.count += 1
            return
        found = Difference(about, kind, tick, account())
        self.differences[key] = found
        self.on_new(found)

    @property
    def agreed(self) -> int:
        """How often both agreed, in whatever it was."""
        return sum(row.agreed for row in self.rows.values())

    @property
    def total(self) -> int:
        """How often they were compared."""
        return sum(row.total for row in self.rows.values())

    @property
    def share(self) -> float:
        """From 0 to 1; 1 if nothing was compared."""
        return self.agreed / self.total if self.total else 1.0

    def forgive(self, share: float) -> None:
        """Leave out what only one side has sent, if that is no more than a share of everything."""
        alone = [each for each in self.differences.values() if each.kind in ALONE]
        count = sum(each.count for each in alone)
        if not count or count > ceil(share * self.total):
            return
        for each in alone:
            del self.differences[each.subject, each.kind]
            self._row(each.subject).differed -= each.count
        self.remarks.append(f"{count} frames that only one side has are taken for lost lines")

    def services(self, node: str) -> set[str]:
        """What was compared of a node at all."""
        return {subject.service for subject in self.rows if subject.node == node}

    def _row(self, subject: Subject) -> Row:
        row = self.rows.get(subject)
        if row is None:
            row = self.rows[subject] = Row()
        return row
