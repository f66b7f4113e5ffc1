"""Whether what a device sent is what its twin sent, and in what words they differ."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, partial

from canopen import SdoAbortedError

from canopen_twins.bus import identifiers, sdo
from canopen_twins.bus.clock import MICROSECONDS, microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Record
from canopen_twins.device.node import Node
from canopen_twins.device.timing import Timing
from canopen_twins.diagnosis.decoder import STATES, Decoder
from canopen_twins.diagnosis.why import why
from canopen_twins.record.compare.agreement import Account, Agreement, Kind, Subject
from canopen_twins.record.compare.dialogue import Answer, Outcome, Transfer, outcome
from canopen_twins.record.compare.shown import Shown
from canopen_twins.record.compare.stream import Pair, Seen
from canopen_twins.record.compare.tolerances import Tolerances
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.emcy import emcy_of
from canopen_twins.slave.error_control import TOGGLE
from canopen_twins.slave.object import Address, Entry, Rejected
from canopen_twins.slave.pdo import carried, packed
from canopen_twins.slave.tpdo import Tpdo

SDO, ANSWER_TIME = "SDO", "SDO answer time"
STATES_OF = ("heartbeat", "node guarding")
STORING = (0x1010, 0x1011)
RECENT = 40  # frames that `why` looks at
SHOWN = 3  # answers of a transfer that are shown


class Judge:
    """Of one node. What it finds goes to an agreement."""

    def __init__(
        self,
        node: Node,
        agreement: Agreement,
        tolerances: Tolerances,
        records: deque[Record],
        expected: Timing,
    ) -> None:
        """`expected` is how long the device is said to take."""
        self.shown: Shown | None = None
        """What the device shows, for whoever wants to know."""
        self.node = node
        self.name = node.wire.name
        self.agreement = agreement
        self.tolerances = tolerances
        self._records = records
        self._expected = expected
        self._decoder = Decoder([node])
        self._answer_time = Subject(self.name, ANSWER_TIME)
        self._subjects: dict[Address | None, Subject] = {}

    # SDO

    def transfer(self, transfer: Transfer) -> None:
        """A transfer that is over on both sides."""
        device, twin = transfer.device, transfer.twin
        subject = self._about(transfer.address)
        if [each.data for each in device] == [each.data for each in twin] or (
            found := self._unlike(transfer)
        ) is None:
            self.agreement.agree(subject)
        else:
            kind, text = found
            self.agreement.differ(
                subject, kind, transfer.tick, lambda: self._account(transfer, text)
            )
        for answer in device if twin else ():
            self._judge_delay(transfer, answer)

    def _judge_delay(self, transfer: Transfer, answer: Answer) -> None:
        if self.shown is not None:
            stores = _stores(transfer)
            times = self.shown.store_times if stores else self.shown.answer_times
            self.shown.keep(times, answer.delay)
        least, most = self._span(transfer)
        if least - self.tolerances.time <= answer.delay <= most + self.tolerances.time:
            self.agreement.agree(self._answer_time)
            return
        subject = self._about(transfer.address) if _stores(transfer) else None

        def account() -> Account:
            span = _seconds(least) if least == most else f"{_seconds(least)} to {_seconds(most)}"
            return self._account(transfer, f"after {_seconds(answer.delay)}, the twin after {span}")

        self.agreement.differ(self._answer_time, Kind.TIME, transfer.tick, account, subject)

    def _span(self, transfer: Transfer) -> tuple[int, int]:
        """Microseconds that an answer takes at least and at most, as the settings say."""
        least = microseconds(self._expected.answer_time)
        most = microseconds(longest_answer(self._expected))
        if _stores(transfer) and not self._expected.store_refuses:
            extra = microseconds(self._expected.store_time)
            return (least + extra * (outcome(transfer.twin).code is None), most + extra)
        return least, most

    def _unlike(self, transfer: Transfer) -> tuple[Kind, str] | None:
        """In what the answers differ; none if only in what means nothing."""
        if not transfer.device:
            if (
                transfer.until is not None
                and transfer.until - transfer.tick < self._span(transfer)[1]
            ):
                return None  # the next one has taken its place
            return Kind.LACKS, "the device has not answered, the twin has"
        if not transfer.twin:
            return Kind.MORE, "the device has answered, the twin has not"
        if len(transfer.device) != transfer.requests and not transfer.in_blocks:
            return Kind.LACKS, "not every segment is in the trace"
        device, twin = outcome(transfer.device), outcome(transfer.twin)
        if device.code != twin.code:
            return _other_code(device.code, twin.code)
        return self._other_answer(transfer, device, twin)

    def _other_answer(
        self, transfer: Transfer, device: Outcome, twin: Outcome
    ) -> tuple[Kind, str] | None:
        if device.form != twin.form:
            return Kind.FORM, f"{device.form}, not {twin.form}"
        if not self._same_value(transfer, device, twin):
            return Kind.VALUE, f"{self._value(transfer, device)}, not {self._value(transfer, twin)}"
        if _heads(transfer.device) != _heads(transfer.twin):
            return Kind.FORM, "an answer that begins otherwise"
        return None

    def _same_value(self, transfer: Transfer, device: Outcome, twin: Outcome) -> bool:
        if device.value == twin.value:
            return True
        entry = self.entry(transfer.address)
        if entry is None or device.value is None or twin.value is None:
            return False
        if entry.size is not None and {len(device.value), len(twin.value)} != {entry.size}:
            return device.value[: entry.size] == twin.value[: entry.size]
        if self.shown is not None and entry.address in self._measured:
            self.shown.pair(entry.address, entry.unpack(device.value), entry.unpack(twin.value))
        others = [twin.value]
        if transfer.before is not None:  # from the request on, until now
            others += [transfer.before, self.look(entry.address) or transfer.before]
        return self._same(entry, device.value, others)

    def _same(self, entry: Entry, one: bytes, others: Sequence[bytes]) -> bool:
        """Whether a value is one of the twin's, or between them if it is measured."""
        value, twins = entry.unpack(one), [entry.unpack(other) for other in others]
        noise = self._expected.noise if entry.address in self._measured else None
        if noise is not None and all(isinstance(each, int | float) for each in twins):
            twins.append(min(max(value, min(twins)), max(twins)))
        same = self.tolerances.same
        return any(same(entry.address, noise, value, each) for each in twins)

    def look(self, address: Address) -> bytes | None:
        """What the twin would answer now, if that is something measured."""
        if address not in self._measured or (entry := self.entry(address)) is None:
            return None
        self.node.look()
        return entry.read()

    def _value(self, transfer: Transfer, told: Outcome) -> str:
        value = told.value or b""
        entry = self.entry(transfer.address)
        if entry is None or entry.size not in (None, len(value)):
            return value.hex(" ") or "nothing"
        return str(entry.unpack(value))

    def unasked(self, tick: int, data: bytes) -> None:
        """An answer of the device to nothing that the trace has."""
        frame = Frame(identifiers.sdo_answer(self.node.node_id), data)
        subject = Subject(self.name, SDO)
        text = "an answer to a request that the trace does not have"
        self.agreement.differ(
            subject, Kind.MORE, tick, lambda: Account(text, [self.words(tick, frame)])
        )

    def _account(self, transfer: Transfer, text: str) -> Account:
        request = self.words(transfer.tick, transfer.request)
        device, twin = (self._answers(each) for each in (transfer.device, transfer.twin))
        reasons = self._why(str(transfer.request))
        return Account(text, [request, *(device or ["no answer"])], twin or ["no answer"], reasons)

    def _answers(self, answers: Sequence[Answer]) -> list[str]:
        can_id = identifiers.sdo_answer(self.node.node_id)
        return [self.words(each.tick, Frame(can_id, each.data)) for each in answers[:SHOWN]]

    def _about(self, address: Address | None) -> Subject:
        subject = self._subjects.get(address)
        if subject is None:
            subject = self._subjects[address] = Subject(self.name, SDO, self._named(address))
        return subject

    def _named(self, address: Address | None) -> str:
        if address is None:
            return ""
        entry = self.entry(address)
        return f"{address_text(address)} {entry.variable.qualname if entry else ''}".strip()

    def entry(self, address: Address | None) -> Entry | None:
        """Of the twin; none if it has none, or is silent."""
        slave = self.node.slave
        if address is None or slave is None:
            return None
        try:
            return slave.entry(*address)
        except Rejected:
            return None

    @cached_property
    def _measured(self) -> frozenset[Address]:
        return frozenset(self.node.device.measured)

    # Messages that come by themselves

    def state(self, service: str, pair: Pair) -> None:
        """A heartbeat, or the answer to node guarding."""
        if self.shown is not None and service == STATES_OF[0] and pair.intervals is not None:
            self.shown.keep(self.shown.beats, pair.intervals[0])
        self._message(Subject(self.name, service), pair, self._other_state)

    def same_state(self, device: Seen, twin: Seen) -> bool:
        """Whether both tell one state, or the state of the twin changed in between."""
        one, other = device.frame.data, twin.frame.data
        same_toggle = len(one) == len(other) == 1 and one[0] & TOGGLE == other[0] & TOGGLE
        return same_toggle and one in device.also

    def _other_state(self, device: Seen, twin: Seen) -> str:
        told = [
            STATES.get(each.frame.data[0] & ~TOGGLE, "?") if each.frame.data else "nothing"
            for each in (device, twin)
        ]
        if told[0] == told[1]:
            return "another toggle bit" if len(device.frame.data) == 1 else "another length"
        return f"{told[0]}, not {told[1]}"

    def emcy(self, pair: Pair) -> None:
        """An emergency."""
        self._message(Subject(self.name, "EMCY"), pair, self._other_emcy)

    def _other_emcy(self, device: Seen, twin: Seen) -> str:
        one, other = emcy_of(device.frame.data), emcy_of(twin.frame.data)
        parts = {
            "code": (f"{one.code:04X}h", f"{other.code:04X}h"),
            "register": (f"{one.register:02X}h", f"{other.register:02X}h"),
            "field": (one.field.hex(" "), other.field.hex(" ")),
            "length": (str(len(device.frame.data)), str(len(twin.frame.data))),
        }
        return ", ".join(f"{name} {a}, not {b}" for name, (a, b) in parts.items() if a != b)

    def message(self, service: str, pair: Pair) -> None:
        """Any other: SYNC, an answer of LSS."""
        self._message(Subject(self.name, service), pair, lambda device, twin: "other data")

    def _message(self, subject: Subject, pair: Pair, unlike: Callable[[Seen, Seen], str]) -> None:
        if self._lacks(subject, pair):
            return
        device, twin = pair.device, pair.twin
        assert device is not None
        assert twin is not None
        if device.frame != twin.frame and not self._same_message(subject, device, twin):
            self._differ(subject, Kind.VALUE, pair, unlike(device, twin))
        elif abs(pair.late) > self.tolerances.time:
            self._differ(subject, Kind.TIME, pair, _late(pair))
        else:
            self.agreement.agree(subject)

    def _same_message(self, subject: Subject, device: Seen, twin: Seen) -> bool:
        """Whether a state is one that the twin had when the device told it; clocks may differ."""
        if subject.service == "TIME":
            return True
        return subject.service in STATES_OF and self.same_state(device, twin)

    def _lacks(self, subject: Subject, pair: Pair) -> bool:
        """Whether one of them is lacking, which is told then."""
        if pair.device is None:
            self._differ(subject, Kind.LACKS, pair, "not in the trace")
        elif pair.twin is None:
            self._differ(subject, Kind.MORE, pair, "not from the twin")
        return pair.device is None or pair.twin is None

    def _differ(
        self, subject: Subject, kind: Kind, pair: Pair, text: str, about: Subject | None = None
    ) -> None:
        seen = pair.device or pair.twin
        assert seen is not None
        self.agreement.differ(subject, kind, seen.tick, lambda: self._pair(pair, text), about)

    def _pair(self, pair: Pair, text: str) -> Account:
        device, twin = (
            [self.words(seen.tick, seen.frame)] if seen else ["nothing"]
            for seen in (pair.device, pair.twin)
        )
        seen = pair.twin or pair.device
        return Account(text, device, twin, self._why(str(seen.frame) if seen else ""))

    # PDOs

    def pdo(self, number: int, pair: Pair) -> None:
        """A TPDO, its mapping decoded."""
        subject = Subject(self.name, f"TPDO{number}")
        if self._lacks(subject, pair):
            return
        device, twin = pair.device, pair.twin
        assert device is not None
        assert twin is not None
        if self.shown is not None:
            self._show(self.shown, number, device, twin)
        if device.frame == twin.frame or self.same_pdo(number, device, twin):
            if abs(pair.late) > self.tolerances.time:
                self._differ(subject, Kind.TIME, pair, _late(pair))
            else:
                self.agreement.agree(subject)
            return
        others = list(self._other_parts(number, device, twin))
        if len(device.frame.data) != len(twin.frame.data) or not others:
            text = f"{len(device.frame.data)} bytes, not {len(twin.frame.data)}"
            self._differ(subject, Kind.FORM, pair, text)
            return
        self._row_differs(subject, pair, others)

    def _row_differs(self, row: Subject, pair: Pair, others: Sequence[tuple[Entry, str]]) -> None:
        """The row counts it once, whatever number of values is another."""
        (entry, text), *rest = others
        self._differ(row, Kind.VALUE, pair, text, self._part(row, entry))
        assert pair.device is not None
        for entry, text in rest:
            account = partial(self._pair, pair, text)
            self.agreement.tell(self._part(row, entry), Kind.VALUE, pair.device.tick, account)

    def _show(self, shown: Shown, number: int, device: Seen, twin: Seen) -> None:
        """Keep what a TPDO has brought."""
        slave = self.node.slave
        for part in [] if slave is None else carried(slave, Tpdo.mapping + number - 1):
            entry, frames = part.entry, (device.frame, twin.frame)
            if entry is None or part.end > 8 * min(len(frame.data) for frame in frames):
                continue
            value, other = (entry.unpack(part.value(frame.data)) for frame in frames)
            shown.sample(entry.address, device.tick, value)
            if entry.address in self._measured:
                shown.pair(entry.address, value, other)

    def _part(self, row: Subject, entry: Entry) -> Subject:
        return row._replace(object=self._named(entry.address))

    def same_pdo(self, number: int, device: Seen, twin: Seen) -> bool:
        """Whether two have the same values, or the twin has had these within the tolerance."""
        if len(device.frame.data) != len(twin.frame.data):
            return False
        return next(self._other_parts(number, device, twin), None) is None

    def _other_parts(self, number: int, device: Seen, twin: Seen) -> Iterator[tuple[Entry, str]]:
        """The values that are not the same, each with both in words."""
        slave, data = self.node.slave, device.frame.data
        parts = [] if slave is None else carried(slave, Tpdo.mapping + number - 1)
        others = [twin.frame.data, *(each for each in device.also if len(each) == len(data))]
        for part in parts:
            entry = part.entry
            if entry is None or part.end > 8 * min(map(len, (data, *others))):
                continue
            told, values = part.value(data), [part.value(each) for each in others]
            if told not in values and not self._same(entry, told, values):
                yield entry, f"{entry.unpack(told)}, not {entry.unpack(values[0])}"

    def sent_now(self, number: int) -> bytes:
        """What the twin would send in a TPDO at this moment; it is on the bus."""
        slave = self.node.slave
        assert slave is not None
        self.node.look()
        return packed(carried(slave, Tpdo.mapping + number - 1))

    # Words

    def words(self, tick: int, frame: Frame) -> str:
        """A frame with its time in the trace."""
        told = f"{tick / MICROSECONDS:12.6f}  {frame!s:21}  {self._decoder.words(frame)}"
        return told.rstrip()

    def _why(self, frame: str) -> list[str]:
        """What the twin knows of a frame, or of its silence."""
        lines = why(self.node, list(self._records)[-RECENT:])
        return [line for line in lines if line.startswith(frame) or "silent" in line]


def _stores(transfer: Transfer) -> bool:
    """Whether it is a command to store or to restore."""
    stores = transfer.address is not None and transfer.address[0] in STORING
    return stores and transfer.access == sdo.WRITE


def longest_answer(timing: Timing) -> float:
    """Seconds for an answer that stores nothing."""
    return timing.answer_time + timing.answer_jitter


def _late(pair: Pair) -> str:
    if pair.intervals is not None:
        return (
            f"{_seconds(pair.intervals[0])} after the one before, not {_seconds(pair.intervals[1])}"
        )
    return f"{_seconds(abs(pair.late))} {'later' if pair.late > 0 else 'earlier'}"


def _seconds(microseconds: float) -> str:
    return f"{microseconds / MICROSECONDS:.6f} s"


def _heads(answers: Sequence[Answer]) -> list[bytes]:
    """What the answers say beside their values: of an initiate the object, too."""
    return [each.data[: 1 if place else 4] for place, each in enumerate(answers)]


def _other_code(device: int | None, twin: int | None) -> tuple[Kind, str]:
    if device is None or twin is None:
        who = "the device refuses it" if twin is None else "the twin refuses it"
        return Kind.REFUSAL, f"{who}: {_abort(device or twin or 0)}"
    return Kind.CODE, f"{_abort(device)}, not {_abort(twin)}"


def _abort(code: int) -> str:
    return f"{code:08X}h {SdoAbortedError.CODES.get(code, '')}".strip()
