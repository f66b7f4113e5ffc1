"""One node beside its device: which of its services a frame belongs to, on either side."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from functools import partial

from canopen_twins.bus import identifiers, sdo
from canopen_twins.bus.clock import MICROSECONDS, microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.sdo import Ccs, Scs
from canopen_twins.bus.segment import Record
from canopen_twins.device.device import Device
from canopen_twins.device.node import Node
from canopen_twins.device.settings import TimingSettings
from canopen_twins.device.timing import Timing
from canopen_twins.record.compare.agreement import Account, Agreement, Kind, Subject
from canopen_twins.record.compare.dialogue import Dialogue, Transfer, outcome
from canopen_twins.record.compare.judge import Judge, longest_answer
from canopen_twins.record.compare.middle import Middle
from canopen_twins.record.compare.shown import Shown
from canopen_twins.record.compare.stream import WINDOW, Pair, Seen, Stream
from canopen_twins.record.compare.timeline import Timeline
from canopen_twins.record.compare.tolerances import Tolerances
from canopen_twins.record.compare.unexercised import Exercised
from canopen_twins.slave.emcy import emcy_id
from canopen_twins.slave.error_control import TOGGLE
from canopen_twins.slave.nmt import ALL_NODES, RESETS, STATE_BYTE
from canopen_twins.slave.sdo_server import ANSWERS, REQUESTS, SERVERS
from canopen_twins.slave.service import State
from canopen_twins.slave.slave import Slave
from canopen_twins.slave.sync import COB_ID as SYNC_COB_ID
from canopen_twins.slave.sync import sync_id
from canopen_twins.slave.time import COB_ID as TIME_COB_ID
from canopen_twins.slave.tpdo import Tpdo

BOOT_UP = b"\0"
BOOT, HEARTBEAT, GUARDING, EMCY, SYNC, TIME, LSS = (
    "boot-up",
    "heartbeat",
    "node guarding",
    "EMCY",
    "SYNC",
    "TIME",
    "LSS",
)
PREDEFINED = (0x180, 0x280, 0x380, 0x480)  # TPDOs
STATE_OF = {byte: state for state, byte in STATE_BYTE.items()}
MILLISECOND = 1_000
GUARDED = 20 * MILLISECOND  # microseconds within which node guarding is answered

Handler = Callable[[int, Frame, bool], None]
"""Takes a frame at its time in the trace, and whether it is the device's, not the twin's."""


class Beside:
    """`own` are the identifiers that the node sends with at this moment, each with its service."""

    def __init__(
        self,
        node: Node,
        timeline: Timeline,
        agreement: Agreement,
        tolerances: Tolerances,
        records: deque[Record],
    ) -> None:
        self.node = node
        self.name = node.wire.name
        self.own: dict[int, Handler] = {}
        self.heard: object = None  # by the twin, when `own` was worked out
        self.begun = False
        expected = _at_once(node.device)
        self._judge = Judge(node, agreement, tolerances, records, expected)
        self._patience = max(microseconds(longest_answer(expected)), tolerances.time)
        self._agreement = agreement
        self._tolerances = tolerances
        self._timeline = timeline
        self._segment = timeline.segment
        self._middle = Middle(self._judge, timeline.segment)
        self._dialogue = self._new_dialogue()
        self._further: dict[int, Dialogue] = {}  # by the objects of further SDO servers
        self._requests: dict[int, Dialogue] = {}
        self._streams: dict[str, Stream] = {}
        self._guarded = [-GUARDED, -GUARDED]  # when last, until answered: by twin and device
        self._reset: tuple[int, int] | None = None  # the last: in the trace, and for the twin
        self._booted: tuple[int, int] | None = None  # the twin, before the device
        self._looks: deque[tuple[int, int, list[bytes]]] = deque()  # at TPDOs, a little later
        self.exercised = Exercised()
        self.derive()

    def _new_dialogue(self) -> Dialogue:
        send, look = self._segment.send, self._judge.look
        return Dialogue(self._judge_transfer, self._unasked, send, look, self._patience)

    def show(self) -> Shown:
        """Keep from now on what the device shows."""
        self._judge.shown = Shown()
        return self._judge.shown

    # What comes in

    def on_device(self, tick: int, frame: Frame) -> None:
        """The device has sent a frame that is its own."""
        handle = self.own[frame.can_id]
        if not self.begun:
            self._begin(tick, frame)
        elif self._booted is not None and not _is_boot_up(frame):
            self._never_booted(tick)
        elif self.node.slave is None and not _is_boot_up(frame):
            self._timeline.wait_for(self.node)
        self.own.get(frame.can_id, handle)(tick, frame, True)

    def on_twin(self, tick: int, frame: Frame) -> None:
        """The twin has sent a frame."""
        if self._middle.is_deaf or not self.begun:
            return
        if self._booted is not None and not _is_boot_up(frame):
            return  # the device is not there yet
        handle = self.own.get(frame.can_id)
        if handle is None:
            self.derive()
            handle = self.own.get(frame.can_id, partial(self._plain, f"{frame.can_id:03X}h"))
        handle(tick, frame, False)

    def on_master(self, tick: int, frame: Frame) -> bool:
        """The master has sent a frame; whether the twin gets it from here, now or later."""
        node_id = self.node.node_id
        if frame.remote:
            if frame.can_id == identifiers.heartbeat(node_id):
                self._guarded = [tick, tick]
            return False
        if frame.can_id == identifiers.NMT and len(frame.data) == 2:
            self._on_nmt(tick, *frame.data)
        if (dialogue := self._requests.get(frame.can_id)) is None:
            self._middle.pdos.add(frame.can_id)
            return False
        dialogue.ask(tick, frame)
        return True

    def _on_nmt(self, tick: int, command: int, target: int) -> None:
        if target in (ALL_NODES, self.node.node_id):
            self.exercised.commands.add(command)
            if command in RESETS:
                self._reset = tick, self._clock
            self._middle.knows_state = True

    def follow(self, now: int) -> None:
        """What has to be done between two frames of the trace."""
        for dialogue in self._dialogues:
            dialogue.hurry(now)
        while self._looks and now - self._looks[0][0] >= self._tolerances.time:
            _, number, also = self._looks.popleft()
            if self.node.slave is not None:
                also.append(self._judge.sent_now(number))

    @property
    def due(self) -> float:
        """When the twin is asked, though the device is silent; infinite if nothing waits."""
        return min(dialogue.due for dialogue in self._dialogues)

    @property
    def _dialogues(self) -> Iterable[Dialogue]:
        return self._requests.values()

    def leap(self) -> None:
        """The trace goes on at another time."""
        for stream in self._streams.values():
            stream.forget()

    def settle(self, now: float) -> None:
        """Judge what is so old that nothing more will come of it."""
        for dialogue in self._dialogues:
            dialogue.settle(now)
        for stream in self._streams.values():
            if stream.pending:
                stream.settle(now)

    def end(self, now: int) -> None:
        """Judge all that there is."""
        if self._booted is not None and now - self._booted[0] > WINDOW:
            self._never_booted(now)
        for dialogue in self._dialogues:
            dialogue.end(now - self._tolerances.time)
        for stream in self._streams.values():
            stream.end(now)

    @property
    def _clock(self) -> int:
        return self._segment.clock.ticks

    # Where it goes

    def derive(self) -> None:
        """Work out which identifiers are the node's own, as its dictionary is now."""
        node_id, slave = self.node.node_id, self.node.slave
        self.heard = self.node.wire.heard
        self.own = {
            identifiers.sdo_answer(node_id): partial(self._on_answer, self._dialogue),
            identifiers.heartbeat(node_id): self._on_error_control,
            identifiers.emcy(node_id): self._on_emcy,
        }
        self._requests = {identifiers.sdo_request(node_id): self._dialogue}
        heard = self.heard if isinstance(self.heard, dict) else {}
        for place, base in enumerate(PREDEFINED):
            if (base + node_id, False) not in heard:
                self.own[base + node_id] = partial(self._on_pdo, place + 1)
        if slave is not None:
            self._derive_from(slave)
            if (identifiers.LSS_REQUEST, False) in heard:
                self.own[identifiers.LSS_ANSWER] = partial(self._plain, LSS)

    def _derive_from(self, slave: Slave) -> None:
        if (can_id := emcy_id(slave)) is not None:
            self.own[can_id] = self._on_emcy
        for number in Tpdo.numbers(slave):
            if (can_id := Tpdo.identifier(slave, number)) is not None:
                self.own[can_id] = partial(self._on_pdo, number)
        if slave.has(SYNC_COB_ID) and slave.number(SYNC_COB_ID) & identifiers.PRODUCES:
            self.own[sync_id(slave)] = partial(self._plain, SYNC)
        if slave.has(TIME_COB_ID) and slave.number(TIME_COB_ID) & identifiers.PRODUCES:
            self.own[slave.number(TIME_COB_ID) & identifiers.CAN_ID] = partial(self._plain, TIME)
        for index in SERVERS:
            if slave.has(index, REQUESTS) and slave.has(index, ANSWERS):
                self._derive_server(index, *(slave.number(index, n) for n in (REQUESTS, ANSWERS)))

    def _derive_server(self, index: int, requests: int, answers: int) -> None:
        asked, answered = map(identifiers.of_cob_id, (requests, answers))
        if asked is None or answered is None:
            return
        dialogue = self._further.setdefault(index, self._new_dialogue())
        self._requests[asked] = dialogue
        self.own[answered] = partial(self._on_answer, dialogue)

    def _on_answer(self, dialogue: Dialogue, tick: int, frame: Frame, of_device: bool) -> None:
        if of_device:
            dialogue.add_device(tick, frame.data)
        else:
            dialogue.add_twin(tick, frame.data)

    def _on_error_control(self, tick: int, frame: Frame, of_device: bool) -> None:
        guarding = tick - self._guarded[of_device] < GUARDED and self._may_guard(frame)
        if _is_boot_up(frame) and not guarding:
            self._on_boot_up(tick, of_device)
            return
        if of_device and frame.data and self._middle.infer(STATE_OF.get(frame.data[0] & ~TOGGLE)):
            return
        if of_device and not guarding and self._middle.infer_period(tick):
            self._streams.pop(HEARTBEAT, None)
            return
        if guarding:
            self._guarded[of_device] = -GUARDED
        service = GUARDING if guarding else HEARTBEAT
        stream = self._stream(service, partial(self._judge.state, service), self._judge.same_state)
        self._put(stream, tick, frame, of_device, self._state_byte(frame) if of_device else ())

    def _may_guard(self, frame: Frame) -> bool:
        """Whether it can be the answer to a request: a heartbeat has no toggle bit."""
        heard = self.heard if isinstance(self.heard, dict) else {}
        return (frame.can_id, True) in heard or frame.data[:1] >= bytes([TOGGLE])

    def _on_emcy(self, tick: int, frame: Frame, of_device: bool) -> None:
        self._put(self._stream(EMCY, self._judge.emcy), tick, frame, of_device)

    def _on_pdo(self, number: int, tick: int, frame: Frame, of_device: bool) -> None:
        if of_device and self._middle.infer(State.OPERATIONAL):
            return
        same = partial(self._judge.same_pdo, number)
        stream = self._stream(f"TPDO{number}", partial(self._judge.pdo, number), same)
        also: list[bytes] = []
        if of_device and self.node.slave is not None:
            also.append(self._judge.sent_now(number))
            if also[0] != frame.data:
                self._looks.append((tick, number, also))
        self._put(stream, tick, frame, of_device, also)

    def _plain(self, service: str, tick: int, frame: Frame, of_device: bool) -> None:
        stream = self._stream(service, partial(self._judge.message, service))
        self._put(stream, tick, frame, of_device)

    def _put(
        self, stream: Stream, tick: int, frame: Frame, of_device: bool, also: Sequence[bytes] = ()
    ) -> None:
        if of_device:
            stream.add_device(Seen(tick, frame, also))
        else:
            stream.add_twin(Seen(tick, frame))

    def _stream(
        self,
        service: str,
        judge: Callable[[Pair], None],
        same: Callable[[Seen, Seen], bool] = lambda device, twin: False,
    ) -> Stream:
        stream = self._streams.get(service)
        if stream is None:
            stream = self._streams[service] = Stream(self._tolerances.time, same, judge)
            stream.free = self._middle.is_here
        return stream

    def _state_byte(self, frame: Frame) -> Sequence[bytes]:
        """As the twin would tell its state at this moment, with the toggle bit of the device."""
        byte = STATE_BYTE.get(self.node.state)
        return () if byte is None or not frame.data else (bytes([byte | frame.data[0] & TOGGLE]),)

    # Booting

    def _begin(self, tick: int, frame: Frame) -> None:
        """The first that is seen of the device: has it just booted, or long before?"""
        self._middle.is_here = not _is_boot_up(frame)
        if self._judge.shown is not None:
            self._judge.shown.begun = tick
        self._boot()
        self.begun = True
        if self._middle.is_here:
            self._agreement.remarks.append(
                f"{self.name}: the trace begins in the middle; objects and NMT state are taken from"
                " what it shows"
            )
        else:
            self._booted = tick, self._clock

    def _boot(self) -> None:
        """Power comes, and all that the twin tells of it is left out."""
        with self._middle.unheard():
            self.node.power_off()
            self.node.power_on()
            self._segment.deliver()
            self._timeline.wait_for(self.node)
        self.derive()

    def _on_boot_up(self, tick: int, of_device: bool) -> None:
        if not of_device:
            self._booted = tick, self._clock
            return
        if self.node.slave is None:
            self._timeline.wait_for(self.node)
        subject = Subject(self.name, BOOT)
        if self._judge.shown is not None and self._reset is not None:
            self._judge.shown.keep(self._judge.shown.boot_times, tick - self._reset[0])
        if self._booted is None:
            text = "nobody has asked for it: a power cycle, or a reset of its own"
            self._tell_boot(subject, Kind.MORE, tick, text)
            self._boot()
        elif abs(late := self._boot_late(tick)) > self._tolerances.time:
            text = f"{abs(late) / MICROSECONDS:.6f} s {'later' if late > 0 else 'earlier'}"
            self._tell_boot(subject, Kind.TIME, tick, f"{text} than the twin")
        else:
            self._agreement.agree(subject)
        for stream in self._streams.values():
            stream.free = True
        self._booted = self._reset = None
        self._middle.end()
        self.derive()

    def _boot_late(self, tick: int) -> int:
        """How much later the device has booted, counted from the command that both have had."""
        assert self._booted is not None
        if self._reset is None:
            return tick - self._booted[0]
        return tick - self._reset[0] - (self._booted[1] - self._reset[1])

    def _never_booted(self, tick: int) -> None:
        assert self._booted is not None
        if tick - self._booted[0] <= self._tolerances.time:
            return  # on its way already when the command came
        text = "the twin has booted, the device goes on without a boot-up message"
        self._tell_boot(Subject(self.name, BOOT), Kind.LACKS, self._booted[0], text)
        self._booted = self._reset = None

    def _tell_boot(self, subject: Subject, kind: Kind, tick: int, text: str) -> None:
        frame = Frame(identifiers.heartbeat(self.node.node_id), BOOT_UP)
        line = [self._judge.words(tick, frame)]
        sides = (line, ["nothing"]) if kind is Kind.MORE else (["nothing"], line)
        if kind is Kind.TIME:
            sides = line, line
        self._agreement.differ(subject, kind, tick, lambda: Account(text, *sides))

    # SDO

    def _judge_transfer(self, transfer: Transfer) -> None:
        if transfer.address is not None:
            self.exercised.objects.add(transfer.address)
        if transfer.access == sdo.WRITE and transfer.address is not None:
            self._middle.written.add(transfer.address)
        else:
            self._middle.take_over(transfer)
        self._judge.transfer(transfer)
        if self._judge.shown is not None:
            self._show(self._judge.shown, transfer)

    def _show(self, shown: Shown, transfer: Transfer) -> None:
        """Keep what was read of an object that nobody had written since it was delivered."""
        device, twin = outcome(transfer.device), outcome(transfer.twin)
        entry = self._judge.entry(transfer.address)
        if entry is None or entry.address in {*self._middle.written, *shown.read}:
            return
        if device.code is None is twin.code and device.value and twin.value:
            told = entry.unpack(device.value), entry.unpack(twin.value)
            shown.read[entry.address], shown.raw[entry.address] = told, device.value

    def _unasked(self, tick: int, data: bytes) -> None:
        """An answer whose request the trace lacks; of a read it is known what that was."""
        self._judge.unasked(tick, data)
        if len(data) != sdo.LENGTH:
            return
        if sdo.specifier(data) == Scs.UPLOAD:
            request = Frame(
                identifiers.sdo_request(self.node.node_id),
                sdo.message(Ccs.UPLOAD, sdo.multiplexer(sdo.address(data))),
            )
            self._dialogue.recover(tick, request, data)
        elif sdo.specifier(data) == Scs.DOWNLOAD:
            self._middle.written.discard(sdo.address(data))
            self._middle.unknown.add(sdo.address(data))


def _at_once(device: Device) -> Timing:
    """How long the device is said to take, which is judged; the twin answers at once, exactly."""
    expected = device.timing
    if isinstance(device.settings, TimingSettings):
        stores = {} if expected.store_refuses else {"store_time": 0.0}
        device.configure(answer_time=0.0, answer_jitter=0.0, noise=0.0, **stores)
    return expected


def _is_boot_up(frame: Frame) -> bool:
    return frame.data == BOOT_UP and frame.can_id & 0x780 == 0x700
