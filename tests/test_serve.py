import time
from contextlib import ExitStack, contextmanager
from queue import SimpleQueue
from threading import Event, Thread
from uuid import uuid4

import can
import canopen
import pytest
from can.interfaces.virtual import VirtualBus, channels
from probe import LEVEL, Probe

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.errors import UserError
from canopen_twins.faults import connect
from canopen_twins.live.bus import ReopenedBus
from canopen_twins.live.serve import LONGEST_WAIT, drive, serve

pytestmark = pytest.mark.usefixtures("quick_to_disconnect")

PATIENCE = 30.0
READ_LEVEL = "605#4000210000000000"
WRITE_FAULTY = "605#2F03210001000000"
HEARTBEAT_10_MS = "605#2B1710000A000000"


def message(text, **flags):
    can_id, data, remote, extended = Frame.parse(text)
    return can.Message(
        arbitration_id=can_id, data=data, is_remote_frame=remote, is_extended_id=extended, **flags
    )


class Master:
    """The other end of a bus, in cansend notation."""

    def __init__(self, bus):
        self.bus = bus

    def send(self, text, **flags):
        self.bus.send(message(text, **flags))

    def hear(self, patience=PATIENCE):
        received = self.bus.recv(patience)
        if received is None:
            return None
        return str(Frame(received.arbitration_id, bytes(received.data), received.is_remote_frame))

    def ask(self, text):
        self.send(text)
        return self.hear()


@contextmanager
def serving(segment, open_bus):
    """Serve in a thread; a bug comes out at the end."""
    ready, stop, bugs = Event(), Event(), []

    def work():
        try:
            serve(segment, open_bus, stop.is_set, ready.set)
        except BaseException as bug:
            bugs.append(bug)
            ready.set()

    thread = Thread(target=work)
    thread.start()
    try:
        assert ready.wait(PATIENCE)
        yield
    finally:
        stop.set()
        thread.join(PATIENCE)
        assert not thread.is_alive()
        for bug in bugs:
            raise bug


@pytest.fixture
def channel():
    return uuid4().hex


@pytest.fixture
def master(channel):
    with VirtualBus(channel) as bus:
        yield Master(bus)


@pytest.fixture
def segment():
    segment = Segment()
    connect(segment, Probe(), "probe").power_on()
    return segment


@pytest.fixture
def served(segment, channel, master):
    """The master of a probe that is served as node 5, after its boot-up."""
    with serving(segment, lambda: VirtualBus(channel)):
        assert master.hear() == "705#00"
        yield master


def test_an_unmodified_master_is_served(served, channel, segment):
    with canopen.Network().connect(interface="virtual", channel=channel) as network:
        remote = network.add_node(5, segment.nodes[0].device.eds)
        remote.sdo[LEVEL[0]].raw = 7
        assert remote.sdo[LEVEL[0]].raw == 7


def test_what_was_sent_before_is_on_the_bus_when_it_is_ready(segment, channel, master):
    heard = []
    serve(
        segment,
        lambda: VirtualBus(channel),
        stopped=lambda: True,
        ready=lambda: heard.append(master.hear(0)),
    )
    assert heard == ["705#00"]


def test_a_remote_frame_asks_for_a_pdo(served):
    served.send("000#0105")
    first = served.hear()
    assert first.startswith("185#")
    assert served.ask("185#R") == first


def test_frames_of_other_kinds_are_left_alone(served):
    served.send(READ_LEVEL, is_fd=True)
    served.send(READ_LEVEL, is_error_frame=True)
    served.send("00000605#4000210000000000")
    served.send("605#4000")
    assert served.ask("605#4003100000000000") == "585#4F03100000000000"
    assert served.hear(0) is None


def test_a_frame_of_one_node_reaches_the_others_and_the_bus(segment, channel, master):
    other = connect(segment, Probe(node_id=6), "other")
    other.power_on()
    with serving(segment, lambda: VirtualBus(channel)):
        assert [master.hear(), master.hear()] == ["705#00", "706#00"]
        assert master.ask("606#2316100164000500") == "586#6016100100000000"  # watch 5, 100 ms
        assert master.ask("605#2B1710000A000000") == "585#6017100000000000"
        assert master.hear() == "705#7F"
        master.send("605#2B17100000000000")
        while master.hear() != "585#6017100000000000":
            pass
        assert master.hear().startswith("086#3081")  # 8130h: its heartbeat was known, and is gone


@pytest.fixture
def heard(segment):
    """What came to the segment from outside."""
    heard = []
    segment.listeners.append(lambda frame, sender: heard.append(str(frame)) if not sender else None)
    return heard


def test_own_frames_that_a_bus_brings_back_are_not_taken_for_others(
    segment, channel, master, heard
):
    with serving(segment, lambda: VirtualBus(channel, receive_own_messages=True)):
        assert master.hear() == "705#00"
        for _ in range(2):
            assert master.ask(READ_LEVEL) == "585#4B00210000000000"
        master.send("585#4B00210000000000")  # as often as we sent it, and once more
        assert master.ask(READ_LEVEL) == "585#4B00210000000000"
    assert heard == [READ_LEVEL, READ_LEVEL, "585#4B00210000000000", READ_LEVEL]


def test_a_bug_of_a_twin_comes_out_and_the_bus_is_left(segment, channel, master):
    def ready():
        master.send(WRITE_FAULTY)

    with pytest.raises(KeyError, match="a bug in an object"):
        serve(segment, lambda: VirtualBus(channel), lambda: False, ready)
    assert segment.listeners == []
    assert channels[channel] == [master.bus.queue]


class Wall:
    """Real time, as a test wants it to be."""

    def __init__(self):
        self.now = 1000.0

    def __call__(self):
        return self.now


class Script(can.BusABC):
    """A bus on which the time of a wall passes: nobody waits."""

    def __init__(self, wall, *requests):
        super().__init__("script")
        self.wall = wall
        self.requests = list(requests)
        self.waits = []
        self.sent = []

    def recv(self, timeout=None):
        self.waits.append(timeout)
        if self.requests and self.requests[0][0] <= self.wall.now:
            return message(self.requests.pop(0)[1])
        self.wall.now += timeout
        return None

    def send(self, msg, timeout=None):
        self.sent.append((round(self.wall.now - 1000, 6), msg.arbitration_id))


@pytest.fixture
def wall():
    return Wall()


@pytest.fixture
def driven(segment, wall):
    """Drive the segment for some seconds of the wall, with requests at their times."""
    with ExitStack() as opened:

        def driven(seconds, *requests):
            begin = wall.now
            script = Script(wall, *((begin + time, text) for time, text in requests))
            bus = ReopenedBus(lambda: opened.enter_context(script))
            segment.listeners.append(bus.transmit)
            drive(segment, bus, lambda: wall.now >= begin + seconds, wall)
            return script

        yield driven


def beats(segment):
    """The times of the segment's clock at which heartbeats are sent."""
    times = []
    segment.listeners.append(
        lambda frame, sender: times.append(segment.clock.now) if frame.can_id == 0x705 else None
    )
    return times


def test_deadlines_are_kept_and_do_not_drift(driven, segment):
    driven(0.005, (0.0, HEARTBEAT_10_MS))
    times = beats(segment)
    script = driven(1.0)
    assert times == pytest.approx([times[0] + n * 0.01 for n in range(100)], abs=1e-9)
    late = [at - n * 0.01 for n, (at, _) in enumerate(script.sent)]
    assert max(late) - min(late) < 1e-4


def test_what_the_last_frame_sets_off_at_once_is_done_before_the_end(driven, segment, wall):
    done = []

    def hear(frame, sender):
        segment.clock.after(0.0, lambda: done.append(str(frame)))
        wall.now += 1  # nothing comes after it

    segment.deliver()
    segment.listeners.append(hear)
    driven(0.5, (0.1, "080#"))
    assert done == ["080#"]


def test_whether_to_stop_is_asked_every_20_ms(driven):
    assert max(driven(0.5).waits) == LONGEST_WAIT == 0.02


def test_a_gap_is_left_out_and_told(driven, segment, wall, caplog):
    driven(0.005, (0.0, HEARTBEAT_10_MS))
    times = beats(segment)
    before = segment.clock.now

    def suspended(frame, sender):
        if len(times) == 3:
            wall.now += 3600

    segment.listeners.append(suspended)
    driven(3600.1)
    assert segment.clock.now - before == pytest.approx(0.1, abs=0.03)
    assert len(times) == pytest.approx(10, abs=3)
    assert [record.getMessage() for record in caplog.records] == [
        "3600.0 s of real time are left out: suspended, or too slow"
    ]


@pytest.fixture
def stalled(driven, segment, wall):
    """The end of a stall of half a second, and what is sent around it with times of the wall."""
    sdo = "605#2B17100010000000", "605#2F001802FE000000", "605#2B0018050A000000"

    def stalled(*requests):
        driven(0.005, *((0.0, text) for text in (*sdo, *requests, "000#0105")))

        def stand_still(frame, sender):
            if frame.can_id == 0x705 and not ends and segment.clock.now > 0.05:
                wall.now += 0.5
                ends.append(wall.now - 1000)

        ends = []
        segment.listeners.append(stand_still)
        sent = driven(1.0).sent
        return ends[0], sent

    return stalled


def around(stall, sent, can_id, period):
    """How many frames come right after a stall, and whether the later ones are in step."""
    times = [time for time, each in sent if each == can_id]
    at_once = [time for time in times if stall <= time < stall + 0.001]
    later = [time - times[0] for time in times if time > stall + 0.001]
    assert len(later) == pytest.approx(0.45 / period, abs=3)
    return len(at_once), all(abs(time / period - round(time / period)) < 0.05 for time in later)


TOLD = "stood still for 0.5 s: periodic messages that are late"


def test_after_a_stall_periodic_messages_are_sent_once_and_go_on_in_step(stalled, caplog):
    end, sent = stalled()
    assert around(end, sent, 0x705, 0.016) == (2, True)  # with the one that was under way
    assert around(end, sent, 0x185, 0.010) == (1, True)
    assert caplog.messages == [f"{TOLD} are sent once"]


def test_after_a_stall_all_of_them_are_sent_if_that_is_wanted(stalled, segment, caplog):
    segment.clock.catches_up = True
    end, sent = stalled()
    assert around(end, sent, 0x705, 0.016) == (32, True)
    assert around(end, sent, 0x185, 0.010)[0] > 45
    assert caplog.messages == [f"{TOLD} follow one another"]


def test_a_model_that_is_too_slow_leaves_room_for_frames_between_its_steps(driven, segment, wall):
    probe, answered = segment.nodes[0].device, []

    def step(dt):
        wall.now += 0.025  # for a cycle of 10 ms

    def listen(frame, sender):
        if frame.can_id == 0x585:
            answered.append(wall.now - 1000)

    probe.rest, probe.step = 0, step
    with segment.nodes[0].acting():
        pass
    segment.listeners.append(listen)
    driven(0.5, *((n / 10, READ_LEVEL) for n in range(5)))
    late = [at - n / 10 for n, at in enumerate(answered)]
    assert len(late) == 5
    assert max(late) <= 2 * 0.025  # the step that was under way, and the one before the frame


@pytest.fixture
def frail(channel):
    """Opens buses that fail in what `failing` names; `attempts` has one item for each opening."""

    class Frail(VirtualBus):
        failing = frozenset()
        attempts = SimpleQueue()
        mute = Event()
        mute.set()

        def __init__(self):
            self.attempts.put(None)
            self.mute.wait()
            if "open" in self.failing:
                raise OSError("no such device")
            super().__init__(channel)

        def send(self, msg, timeout=None):
            if "send" in self.failing:
                raise can.CanOperationError("transmit buffer full")
            super().send(msg, timeout)

        def _recv_internal(self, timeout):
            if "recv" in self.failing:
                raise can.CanOperationError("the network is down")
            return super()._recv_internal(timeout)

    return Frail


def told(caplog):
    """What was logged, but for stalls: a busy machine has some of its own."""
    lines = [(record.levelname, record.getMessage()) for record in caplog.records]
    return [line for line in lines if not line[1].startswith("stood still")]


def ask_until_answered(master):
    answer = None
    while answer is None:
        master.send(READ_LEVEL)
        answer = master.hear(0.1)
    return answer


def test_a_bus_that_is_not_there_at_the_start_is_wrong_input(segment, frail):
    frail.failing = {"open"}
    with pytest.raises(UserError, match=r"^the bus cannot be opened: no such device$"):
        serve(segment, frail, stopped=lambda: True)


def test_a_bus_that_is_gone_is_opened_again_while_time_goes_on(segment, frail, master, caplog):
    with serving(segment, frail):
        assert master.hear() == "705#00"
        frail.attempts.get()
        before = segment.clock.now
        frail.failing = {"recv", "open"}
        for _ in range(3):
            frail.attempts.get(timeout=PATIENCE)
        assert segment.clock.now - before > 0.6  # pauses of 0.1, 0.2 and 0.4 s
        frail.failing = {}
        assert ask_until_answered(master) == "585#4B00210000000000"
    assert told(caplog) == [
        ("ERROR", "the bus has failed, trying again until it works: the network is down"),
        ("WARNING", "the bus works again"),
    ]


def test_a_bus_that_is_heard_but_takes_nothing_has_failed_too(segment, frail, master, caplog):
    with serving(segment, frail):
        assert master.hear() == "705#00"
        frail.attempts.get()
        frail.failing = {"send"}
        for _ in range(2):
            while frail.attempts.empty():
                master.send(READ_LEVEL)
                assert master.hear(0.02) is None
            frail.attempts.get()
        frail.failing = {}
        assert ask_until_answered(master) == "585#4B00210000000000"
    assert told(caplog) == [
        ("ERROR", "the bus has failed, trying again until it works: transmit buffer full"),
        ("WARNING", "the bus works again"),
    ]


def test_time_goes_on_while_a_bus_takes_its_time_to_open(segment, frail, master, caplog):
    with serving(segment, frail):
        assert master.hear() == "705#00"
        frail.attempts.get()
        frail.mute.clear()
        frail.failing = {"recv"}
        frail.attempts.get(timeout=PATIENCE)
        before = segment.clock.now
        while segment.clock.now < before + 0.2:  # until the test's limit, if it stands still
            time.sleep(0.01)
        frail.failing = {}
        frail.mute.set()
        assert ask_until_answered(master) == "585#4B00210000000000"
    assert [words for level, words in told(caplog) if level == "WARNING"] == ["the bus works again"]


def test_a_bus_that_opens_after_the_end_is_left(segment, frail, channel, master):
    with serving(segment, frail):
        assert master.hear() == "705#00"
        frail.attempts.get()
        frail.mute.clear()
        frail.failing = {"recv"}
        frail.attempts.get(timeout=PATIENCE)
    frail.mute.set()
    while channels[channel] != [master.bus.queue]:
        time.sleep(0.01)


def test_a_bug_in_opening_a_bus_comes_out(segment, frail, master):
    def broken():
        if opened:
            raise KeyError("a bug in opening")
        opened.append(frail())
        return opened[0]

    def no_more():
        frail.failing = {"recv"}

    opened = []
    with pytest.raises(KeyError, match="a bug in opening"):
        serve(segment, broken, lambda: False, no_more)
    assert segment.listeners == []
