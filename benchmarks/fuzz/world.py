"""A twin with a random life, and what has to hold of it whatever happens."""

from collections.abc import Mapping
from typing import Any

from benchmarks.fuzz.events import OF_DEVICE, Change, Clear, Event, Inject, Power, Send, Wait
from canopen_twins import Bench
from canopen_twins.bus import identifiers, sdo
from canopen_twins.bus.frame import Frame
from canopen_twins.device.node import Node
from canopen_twins.devices import create
from canopen_twins.diagnosis.why import why
from canopen_twins.errors import UserError
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.emcy import emcy_id
from canopen_twins.slave.nmt import STATE_BYTE
from canopen_twins.slave.object import INTEGER_TYPES
from canopen_twins.slave.service import State
from canopen_twins.slave.tpdo import Tpdo

ON_THE_BUS = frozenset({State.PRE_OPERATIONAL, State.OPERATIONAL})
BYTES = {byte: state for state, byte in STATE_BYTE.items()}
TOGGLE = 0x80
COMMUNICATION, ERRORS = range(0x1000, 0x2000), (0x1001, 0x1003)
BOOTED = 2.0  # seconds
ENDING: tuple[Event, ...] = (Clear(), Power(False), Wait(1.0), Power(True), Wait(BOOTED))
LOOKED_AT = 20  # frames, by `why`
KEPT = 64


class BrokenError(AssertionError):
    """Something does not hold.

    `expect` is what a scenario expects that would hold; `again` is a frame after which it begins.
    """

    def __init__(
        self, words: str, expect: Mapping[str, Any] | None = None, again: Frame | None = None
    ) -> None:
        super().__init__(words)
        self.expect = expect
        self.again = again

    @property
    def kind(self) -> str:
        """Two failures with one kind have one cause, as far as anybody can tell."""
        return str(self).partition(":")[0]


class World:
    """One twin on a bench; `events` is all that has happened to it."""

    def __init__(self, device: str, **settings: Any) -> None:
        self.device = device
        self.settings = settings
        self.events: list[Event] = []
        self.frames = 0
        """From outside."""
        self.failed = False
        """Whether the last event has brought something to light."""
        self._bench = Bench(device, **settings)
        self.node = self._bench.twin.node
        self._disturbed = False  # what is on the bus may be the work of a fault
        self._told: set[bytes] = set()  # emergencies since somebody has done something
        self._begun = self._bench.clock.now
        self._bench.segment.listeners.append(self._hear)

    def do(self, event: Event) -> None:
        """Let something happen; raises `BrokenError`, or whatever a bug raises."""
        self.failed = True
        self._do(event)
        self.failed = False

    def _do(self, event: Event) -> None:
        self.events.append(event)
        if not isinstance(event, Wait):
            self._told.clear()
        match event:
            case Send(frame):
                self.frames += 1
                addressed = self.node.node_id  # a reset may give it the one that is stored
                self._listen(frame, self._bench.put(frame), addressed)
            case Wait(seconds):
                self._bench.run(seconds)
            case Power(on):
                self._switch(on)
            case _:
                try:
                    self._act(event)
                except UserError:  # a parameter that is none
                    self.events.pop()

    def _act(self, event: Event) -> None:
        match event:
            case Inject(fault, parameters):
                self._disturbed |= self.node.faults.known[fault].level != OF_DEVICE
                self._bench.inject(fault, **parameters)
            case Clear():
                self._bench.clear()
            case Change(settings):
                self._bench.set(**settings)

    def _switch(self, on: bool) -> None:
        if on:
            self._bench.power_on()
        else:
            self._bench.power_off()
            if not self.node.faults.active:
                self._disturbed = False

    def _listen(self, frame: Frame, said: list[str], node_id: int) -> None:
        """What came at once; raises `BrokenError` if it is an answer to what is no question.

        `node_id` is the one that the node had when the frame came.

        CiA 301 7.2.4.3: the server answers requests, and an abort is none; a COB-ID has 11 bits
        unless its object says otherwise, and is that of data frames. 7.3.2.2: NMT has one node
        or all of them.
        """
        if self._disturbed or not said:
            return
        asked = frame.can_id == identifiers.sdo_request(node_id)
        asked = asked and not (frame.remote or frame.extended or sdo.is_abort(frame.data))
        answers = [
            text for text in said if text.startswith(f"{identifiers.sdo_answer(node_id):X}#")
        ]
        if answers and not asked:
            raise _unasked(answers[0], frame)
        if frame.can_id == identifiers.NMT and frame.data[1:2] not in (b"\0", bytes([node_id])):
            raise _unasked(said[0], frame)

    # What is heard

    def _hear(self, frame: Frame, sender: str) -> None:
        if not sender or self._disturbed:
            return
        can_id, node_id = frame.can_id, self.node.node_id
        if can_id == identifiers.sdo_answer(node_id):
            if self.node.state not in ON_THE_BUS:
                self._expect(frame, ON_THE_BUS)
        elif can_id == identifiers.heartbeat(node_id):
            self._hear_state(frame)
        elif can_id != identifiers.LSS_ANSWER:
            self._hear_other(frame)

    def _states(self) -> set[str]:
        return self.node.wire.events.states(self._bench.clock.now)

    def _expect(self, frame: Frame, states: frozenset[State]) -> None:
        """Raises `BrokenError` for a frame that is not sent in the state there is."""
        known = self._states()
        if not known & states:
            told = ", ".join(sorted(known)).lower()
            raise BrokenError(f"not silent: {frame} in {told}", {"never": {"frame": str(frame)}})

    def _hear_state(self, frame: Frame) -> None:
        states = self._states()
        told = BYTES.get(frame.data[0] & ~TOGGLE or frame.data[0])
        if frame.data == b"\0":
            right = State.PRE_OPERATIONAL in states
        else:
            right = told is not None and told in states
        if len(frame.data) != 1 or not right:
            words = f"untrue heartbeat: {frame} in {', '.join(sorted(states)).lower()}"
            raise BrokenError(words, {"never": {"frame": str(frame)}})

    def _hear_other(self, frame: Frame) -> None:
        """EMCY and PDOs, and SYNC and TIME of a node that produces them."""
        slave = self.node.slave
        if slave is not None and frame.can_id == emcy_id(slave):
            self._expect(frame, ON_THE_BUS)
            self._hear_emcy(frame)
        elif self.node.state is not State.OPERATIONAL and self._is_pdo(frame.can_id):
            self._expect(frame, frozenset({State.OPERATIONAL}))

    def _is_pdo(self, can_id: int) -> bool:
        slave = self.node.slave
        if slave is None:
            return False
        return any(Tpdo.identifier(slave, number) == can_id for number in Tpdo.numbers(slave))

    def _hear_emcy(self, frame: Frame) -> None:
        if not int.from_bytes(frame.data[:2], "little"):
            self._told.clear()
        elif frame.data in self._told:
            raise BrokenError(f"EMCY twice: {frame}", {"never": {"frame": str(frame)}}, frame)
        else:
            self._told.add(frame.data)

    # What is looked at

    def look(self) -> None:
        """Limits hold, and `why` says nothing that the frames do not; raises `BrokenError`."""
        self.failed = True
        self._look_at_limits()
        self._look_at_why()
        self.failed = False
        del self._bench.trace[:-KEPT]

    def _look_at_limits(self) -> None:
        slave = self.node.slave
        if slave is None:
            return
        for entries in slave.entries.values():
            for entry in entries.values():
                limited = entry.low is not None or entry.high is not None
                if not (limited and entry.writable and entry.readable):
                    continue
                if entry.variable.data_type not in INTEGER_TYPES:
                    continue
                value = entry.unpack(entry.read())
                low = entry.low if entry.low is not None else value
                high = entry.high if entry.high is not None else value
                if value and not low <= value <= high:  # 0 is off, where a range is above it
                    where = address_text(entry.address)
                    raise BrokenError(
                        f"limits: {where} is {value}, not in {low}..{high}",
                        {"value": {where: {"min": low, "max": high}}},
                    )

    def _look_at_why(self) -> None:
        records = self._bench.trace[-LOOKED_AT:]
        for line in why(self.node, records):
            if not line or "\n" in line:
                raise BrokenError(f"why: {line!r} is no line")
        if self._disturbed:
            return
        for line in why(self.node, records):
            text, _, rest = line.partition(" ")
            if "#" in text and rest.startswith(("refused", "not answered")):
                self._compare(text, rest, records)

    def _compare(self, text: str, rest: str, records: Any) -> None:
        """A request that is said to be refused has an abort behind it, or has no answer."""
        request = identifiers.sdo_request(self.node.node_id)
        answer = identifiers.sdo_answer(self.node.node_id)
        seen = []
        for place, record in enumerate(records):
            if str(record.frame) == text and record.frame.can_id == request:
                behind = []
                for later in records[place + 1 :]:
                    if later.frame.can_id == request:
                        break
                    if later.frame.can_id == answer and later.sender:
                        behind.append(later.frame.data)
                aborted = any(sdo.is_abort(data) for data in behind)
                seen.append("refused" if aborted else "answered" if behind else "not answered")
        if seen and not any(rest.startswith(each) for each in seen):
            raise BrokenError(f"why: {text} {rest}, but it was {' and '.join(seen)}")

    def end(self) -> None:
        """What was wrong is gone when it is cleared and the supply has been off: raises if not."""
        for event in ENDING:
            self.do(event)
        self.compare()

    def compare(self) -> None:
        """Nothing of what has been cleared is left; raises `BrokenError`."""
        self.failed = True
        if self.node.faults.active:
            raise BrokenError(f"clear: {', '.join(self.node.faults.active)} is still there")
        if self.node.slave is None and not self.node.device.silence:
            raise BrokenError("clear: it does not boot")
        self._compare_with_new()
        self.failed = False

    def _compare_with_new(self) -> None:
        """Its communication is that of another one with the same settings and memory."""
        device = create(self.device, **vars(self.node.device.settings))
        device.memory = self.node.device.memory
        fresh = Bench({"fresh": device})
        fresh.run(BOOTED)
        ours, theirs = _communication(self.node), _communication(fresh.twin.node)
        for address, value in theirs.items():
            if ours and ours.get(address) != value:
                where, wanted = address_text(address), int.from_bytes(value, "little")
                words = f"clear: {where} is {ours.get(address)!r}, not {value!r}"
                raise BrokenError(words, {"value": {where: wanted}})


def _unasked(said: str, frame: Frame) -> BrokenError:
    return BrokenError(f"not silent: {said} after {frame}", {"never": {"frame": said}})


def _communication(node: Node) -> Mapping[sdo.Address, bytes]:
    """All values of the communication area, but for errors, which may have a cause that lasts."""
    entries = {} if node.slave is None else node.slave.entries
    return {
        entry.address: entry.read()
        for index, subs in entries.items()
        if index in COMMUNICATION and index not in ERRORS
        for entry in subs.values()
        if entry.readable
    }
