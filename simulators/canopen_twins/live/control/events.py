"""What happens on a bus, told as it happens: decoded by the twins' thread, taken by the port's."""

import logging
from collections import Counter, deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from functools import partial
from typing import Any

from canopen_twins.bus import sdo
from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Record, Segment
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.decoder import Decoder
from canopen_twins.diagnosis.why import why_frame
from canopen_twins.live.bus import steady
from canopen_twins.live.control.schema import DetailedEvent, EmcyEvent, Event, FrameEvent
from canopen_twins.live.control.view import LONGEST_PORTION, emergency
from canopen_twins.live.orders import Orders, Portions
from canopen_twins.scenario import Player, PlayerEvent
from canopen_twins.scenario.frame_matchers import EmcyLike
from canopen_twins.scenario.started import START
from canopen_twins.slave.emcy import emcy_of
from canopen_twins.slave.service import State

OURS = logging.getLogger("canopen_twins")
KEPT = 500  # frames that may be asked about
MOST_WAITING = 10_000  # events that the port has not taken yet, frames that are not decoded yet
KINDS = ("frame", "emcy", "state", "order", "step", "inject", "clear", "outcome", "note", "lost")
EMCY = EmcyLike()
WHY_OF = 20  # frames before a refusal that are looked at


class Events:
    """Keeps the last frames; decodes what comes while somebody watches, in portions.

    Where more comes than can be decoded, what is older is lost, and that is told.
    """

    def __init__(self, segment: Segment[Node], orders: Orders) -> None:
        self.records: deque[Record] = deque(maxlen=KEPT)
        """Only for the thread of the twins."""
        self.watched: Counter[str] = Counter()
        """How many want events of a kind; `take` is for them."""
        self._clock = segment.clock
        self._orders = orders
        self._nodes = {node.wire.name: node for node in segment.nodes}
        self._decoder = Decoder(segment.nodes)
        self._coming: deque[Record | Event] = deque()  # in the order in which it happened
        self._ready: deque[Event] = deque(maxlen=MOST_WAITING)
        self._decoding = False
        self._lost = 0
        segment.listeners.append(self._hear)
        segment.order_listeners.append(self._hear_order)
        for name, node in self._nodes.items():
            node.listeners.append(partial(self._hear_state, name))

    def take(self) -> Iterator[Event]:
        """What has been told since, once; for one thread, that of the port."""
        while self._ready:
            yield self._ready.popleft()

    def follow(self, player: Player) -> None:
        """Tell what a player does, too."""
        player.listeners.append(self._hear_player)

    @contextmanager
    def with_notes(self) -> Iterator[None]:
        """What people are warned of on stderr is told here, too: a stall, a double node id."""
        handler = Notes(self)
        OURS.addHandler(handler)
        try:
            yield
        finally:
            OURS.removeHandler(handler)

    def note(self, words: str) -> None:
        """Tell something that concerns the bus."""
        self._tell_of(Event("note", self._clock.ticks, "", words))

    def last(self, count: int, after: int = -1) -> list[Record]:
        """The last frames, those after a moment in microseconds; for the thread of the twins."""
        records = [*self.records][-count:]
        return [each for each in records if round(each.time * MICROSECONDS) > after]

    def words(self, record: Record) -> FrameEvent:
        """A frame, decoded; for the thread of the twins."""
        time, frame, sender = record
        moment, words = round(time * MICROSECONDS), self._decoder.words(frame)
        return FrameEvent("frame", moment, sender, words, str(frame), self._reasons(record))

    def _hear(self, frame: Frame, sender: str) -> None:
        record = Record(self._clock.now, frame, sender)
        self.records.append(record)
        watched = self.watched
        if watched["frame"] or (watched["emcy"] and self._is_emcy(record)):
            self._come(record)

    def _is_emcy(self, record: Record) -> bool:
        node = self._nodes.get(record.sender)
        return node is not None and EMCY.fits(record.frame, node)

    def _come(self, news: Record | Event) -> None:
        if len(self._coming) >= MOST_WAITING:
            self._coming.popleft()
            self._lost += 1
        self._coming.append(news)
        if not self._decoding:
            self._decoding = True
            self._orders.put_portions(self._decode()).add_done_callback(_raise)

    def _decode(self) -> Portions[None]:
        """As many as there are now, so that other orders have their turn."""
        begun = steady()
        for _ in range(len(self._coming)):
            self._tell(self._coming.popleft())
            if steady() - begun > LONGEST_PORTION:
                yield
                begun = steady()
        self._decoding = False
        if self._lost:
            words, self._lost = f"{self._lost} came faster than they could be told", 0
            self._ready.append(Event("lost", self._clock.ticks, "", words))

    def _tell(self, news: Record | Event) -> None:
        if isinstance(news, Event):
            self._ready.append(news)
            return
        record, event = news, self.words(news)
        self._ready.append(event)
        if self._is_emcy(record):
            error = emergency(emcy_of(record.frame.data))
            self._ready.append(EmcyEvent("emcy", event.moment, event.node, event.words, error))

    def _reasons(self, record: Record) -> list[str]:
        """Why a node refused; nothing of other frames."""
        node, frame = self._nodes.get(record.sender), record.frame
        if node is None or not sdo.is_answer(frame, node.node_id) or not sdo.is_abort(frame.data):
            return []
        place = next((i for i, each in enumerate(self.records) if each is record), None)
        if place is None:
            return []
        around = [*self.records][max(0, place - WHY_OF) : place + 1]
        return why_frame(node, around, frame)

    def _hear_state(self, name: str, state: State) -> None:
        self._add("state", name, state.lower(), state=str(state))

    def _hear_order(self, name: str, word: str, arguments: Any) -> None:
        self._add("order", name, order_words(word, arguments), order=word, arguments=arguments)

    def _hear_player(self, event: PlayerEvent) -> None:
        if event.kind != "state":  # nodes tell their states themselves
            told = " ".join(str(value) for value in event.fields.values())
            self._add(event.kind, event.node, told, **event.fields)

    def _add(self, kind: str, node: str, words: str, **details: Any) -> None:
        self._tell_of(DetailedEvent(kind, self._clock.ticks, node, words, details))

    def _tell_of(self, event: Event) -> None:
        if self.watched[event.kind]:
            self._come(event)


class Notes(logging.Handler):
    """Warnings as events."""

    def __init__(self, events: Events) -> None:
        super().__init__(logging.WARNING)
        self._events = events

    def emit(self, record: logging.LogRecord) -> None:
        """Tell one."""
        self._events.note(record.getMessage())


def _raise(done: "Future[None]") -> None:
    """Nobody waits for it: a bug is logged with its traceback."""
    if not done.cancelled():
        done.result()


def order_words(word: str, arguments: Sequence[Any]) -> str:
    """An order as it is written on the command line, but for the text of a scenario."""
    told = [word.replace("_", " ")]
    for argument in arguments[:1] if word == START else arguments:
        if isinstance(argument, Mapping):
            told += [f"{key}={value}" for key, value in argument.items()]
        elif argument is not None:
            told.append(str(argument))
    return " ".join(told)
