"""Whatever comes over the bus: no bug comes to light, and silence where CiA 301 wants it."""

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from probe import FAULTY, Probe, configure

from canopen_twins import Bench
from canopen_twins.bus.frame import Frame
from canopen_twins.slave.service import State

COMMANDS = {
    State.PRE_OPERATIONAL: "000#8005",
    State.OPERATIONAL: "000#0105",
    State.STOPPED: "000#0205",
}
HEARD = [0x000, 0x080, 0x205, 0x305, 0x605]
ASKED_FOR = [0x185, 0x285]
SDO, ANSWER = 0x605, 0x585
ADDRESSES = [
    *((index, 0) for index in range(0x2000, 0x200E)),
    *((index, 0) for index in range(0x2100, 0x2107)),
    *((record, sub) for record in (0x1400, 0x1401, 0x1800, 0x1801) for sub in (1, 2)),
    *((record, sub) for record in (0x1600, 0x1601, 0x1A00, 0x1A01) for sub in (0, 1, 2)),
    *((0x1003, 0), (0x1005, 0), (0x1008, 0), (0x1010, 1), (0x1014, 0), (0x1016, 1), (0x1017, 0)),
    *((0x1800, 3), (0x1800, 5), (0x200D, 2), (0x2FFF, 0), (0x1000, 0)),
]

data = st.binary(max_size=12)
any_id = st.one_of(
    st.sampled_from([*HEARD, *ASKED_FOR, 0x405, 0x505, 0x606, 0x600, 0x705, 0x706, 0x7E5]),
    st.integers(0, 0x7FF),
)
any_frame = st.one_of(
    st.builds(Frame, any_id, data, st.just(False), st.just(False)),
    st.builds(Frame, any_id, st.just(b""), st.just(True), st.just(False)),
    st.builds(
        Frame, st.one_of(any_id, st.integers(0, 0x1FFFFFFF)), data, st.booleans(), st.just(True)
    ),
)
multiplexers = st.sampled_from(ADDRESSES).map(
    lambda at: at[0].to_bytes(2, "little") + bytes([at[1]])
)
values = st.one_of(
    st.binary(min_size=4, max_size=4),
    st.sampled_from([bytes(4), b"\1\0\0\0", b"\x85\1\0\x80", b"\x08\0\0\x20", b"\xff" * 4]),
)
initiates = st.builds(
    lambda command, multiplexer, value: bytes([command]) + multiplexer + value,
    st.one_of(st.sampled_from([0x22, 0x23, 0x2B, 0x2F, 0x40]), st.integers(0x20, 0x5F)),
    multiplexers,
    values,
)
blocks = st.builds(
    lambda command, multiplexer, value: bytes([command]) + multiplexer + value,
    st.integers(0xA0, 0xDF),
    multiplexers,
    values,
)
requests = st.one_of(initiates, blocks, st.binary(min_size=8, max_size=8))
nmt = st.builds(
    lambda command, node_id: bytes([command, node_id]),
    st.sampled_from([0x01, 0x02, 0x80, 0x81, 0x82, 0x7F]),
    st.sampled_from([0, 5, 6]),
)


def on(can_id):
    return lambda data: Frame(can_id, data)


likely = st.one_of(
    requests.map(on(SDO)),
    nmt.map(on(0x000)),
    st.binary(max_size=8).map(on(0x205)),
    st.binary(max_size=8).map(on(0x305)),
    st.just(Frame(0x080)),
    st.just(Frame(0x285, remote=True)),
)
story = st.lists(st.one_of(likely, any_frame, st.floats(0.0, 0.5)), max_size=25)


class Sound(Probe):
    """A probe without a bug."""

    @property
    def objects(self):
        return {address: acts for address, acts in super().objects.items() if address != FAULTY}


def make(**profile):
    return Bench.of({"probe": Sound(**profile)})


def state(bench):
    return bench.twin.node.state


def play(bench, event):
    """Let a frame or some time pass; what the node sends."""
    sent = bench.run(event) if isinstance(event, float) else bench.put(event)
    return [Frame.parse(text) for text in sent]


def memory(bench):
    """Everything the dictionary holds, as far as it is the node's own."""
    return {index: dict(cell) for index, cell in bench.twin.node.slave.data_store.items()}


def is_reset(frame):
    return frame.can_id == 0 and frame.data[:1] in (b"\x81", b"\x82")


@settings(max_examples=150)
@given(st.sampled_from(sorted(COMMANDS)), any_frame)
def test_what_is_none_of_its_business_is_not_answered(before, frame):
    bench = make()
    bench.send(COMMANDS[before])
    answers = play(bench, frame)
    heard = ASKED_FOR if frame.remote else HEARD
    if frame.extended or frame.can_id not in heard:
        assert answers == []
    if before is not State.OPERATIONAL and frame.can_id not in (0x000, SDO):
        assert answers == []
    if before is State.STOPPED and frame.can_id != 0x000:
        assert answers == []


@settings(max_examples=100)
@given(st.sampled_from(sorted(COMMANDS)), any_frame)
def test_what_is_not_answered_changes_nothing_but_by_a_pdo_or_nmt(before, frame):
    bench = make()
    bench.send(COMMANDS[before])
    held = memory(bench)
    if not play(bench, frame) and frame.can_id not in (0x000, 0x205, 0x305):
        assert (memory(bench), state(bench), bench.device.level) == (held, before, 0)


@pytest.mark.parametrize("block", [False, True])
@settings(max_examples=60)
@given(story)
def test_after_any_story_the_node_still_answers(block, story):
    bench = make(block=block)
    for event in story:
        play(bench, event)
    for frame in ("605#8000000000000000", COMMANDS[State.PRE_OPERATIONAL]):
        bench.send(frame)
    assert bench.send("605#4000100000000000")[0] == "585#4300100000000000"


@settings(max_examples=60)
@given(story)
def test_in_any_story_a_node_that_is_stopped_is_silent(story):
    bench = make()
    for event in story:
        before = state(bench)
        sent = play(bench, event)
        if before is State.STOPPED and not (isinstance(event, Frame) and event.can_id == 0):
            assert {frame.can_id for frame in sent} <= {0x705}  # its heartbeat


@settings(max_examples=60)
@given(story)
def test_in_any_story_a_boot_up_follows_a_reset_and_nothing_else(story):
    bench = make()
    for event in story:
        boot_ups = [frame for frame in play(bench, event) if frame == Frame(0x705, b"\0")]
        assert len(boot_ups) <= 1
        if boot_ups:
            assert is_reset(event)


@settings(max_examples=100)
@given(st.lists(requests, max_size=20))
def test_every_sdo_request_has_one_answer_of_eight_bytes_and_an_abort_has_none(requests):
    bench = make()
    for request in requests:
        answers = [frame for frame in play(bench, Frame(SDO, request)) if frame.can_id == ANSWER]
        assert [len(frame.data) for frame in answers] == [8] * (request[0] >> 5 != 4)


@settings(max_examples=150)
@given(st.lists(initiates, min_size=1, max_size=10))
def test_every_initiate_is_answered_for_its_own_object_and_what_is_refused_changes_nothing(
    requests,
):
    bench = make()
    for request in requests:
        held, level = memory(bench), bench.device.level
        answer = play(bench, Frame(SDO, request))[0]
        assert answer.can_id == ANSWER
        assert answer.data[1:4] == request[1:4]
        assert answer.data[0] in (0x80, 0x60) if request[0] < 0x40 else answer.data[0] != 0x60
        if answer.data[0] == 0x80:
            assert (memory(bench), bench.device.level) == (held, level)


@settings(max_examples=60)
@given(st.lists(requests, max_size=20), st.binary(min_size=8, max_size=8))
def test_what_is_aborted_stays_aborted(requests, segment):
    bench = make()
    for request in requests:
        play(bench, Frame(SDO, request))
    play(bench, Frame(SDO, b"\x80" + bytes(7)))
    (answer,) = play(bench, Frame(SDO, bytes([segment[0] & 0x1F]) + segment[1:]))
    assert answer.data == bytes.fromhex("8000000001000405")


@settings(max_examples=50)
@given(st.lists(st.binary(max_size=12), max_size=5))
def test_an_rpdo_brings_its_bytes_or_nothing(frames):
    bench = make()
    bench.send(COMMANDS[State.OPERATIONAL])
    byte, word = b"\0", b"\x34\x12"
    for content in frames:
        play(bench, Frame(0x205, content))
        if len(content) >= 3:
            byte, word = content[:1], content[1:3]
        slave = bench.twin.node.slave
        assert (slave.entry(0x2000, 0).read(), slave.entry(0x2001, 0).read()) == (byte, word)


@settings(max_examples=50)
@given(st.lists(st.one_of(st.just("sync"), st.binary(max_size=6)), max_size=12))
def test_a_synchronous_rpdo_brings_the_last_whole_frame_before_the_sync(events):
    bench = make()
    bench.send(COMMANDS[State.OPERATIONAL])
    waiting = taken = bytes(4)
    for event in events:
        if event == "sync":
            taken = waiting
        elif len(event) >= 4:
            waiting = event[:4]
        play(bench, Frame(0x080) if event == "sync" else Frame(0x305, event))
        assert bench.twin.node.slave.entry(0x2002, 0).read() == taken


@settings(max_examples=50)
@given(st.integers(1, 240), st.integers(0, 500), st.integers(0, 0xFFFFFFFF))
def test_a_synchronous_tpdo_carries_its_object_with_every_nth_of_any_number_of_syncs(
    kind, syncs, value
):
    bench = make()
    configure(bench, f"605#2F011802{kind:02X}000000")
    bench.sdo["Double word"].raw = value
    bench.send(COMMANDS[State.OPERATIONAL])
    sent = [frame for _ in range(syncs) for frame in play(bench, Frame(0x080))]
    assert sent == [Frame(0x285, value.to_bytes(4, "little"))] * (syncs // kind)


@settings(max_examples=50)
@given(
    st.integers(0, 3000),
    st.integers(0, 200),
    st.lists(st.tuples(st.floats(0.0, 0.1), st.integers(0, 3)), max_size=20),
)
def test_an_event_driven_tpdo_keeps_its_times_and_its_master_up_to_date(inhibit, period, jumps):
    bench = make()
    times = (inhibit.to_bytes(2, "little").hex(), period.to_bytes(2, "little").hex())
    configure(bench, "605#2300180185010080", f"605#2B001803{times[0]}0000")
    configure(bench, f"605#2B001805{times[1]}0000", "605#2300180185010000")
    bench.send(COMMANDS[State.OPERATIONAL])
    for seconds, level in jumps:
        bench.run(seconds)
        bench.inject("level", value=level)
    bench.run(1.0)
    sent = [record for record in bench.trace if record.frame.can_id == 0x185]
    ticks = [round(record.time * 1_000_000) for record in sent]
    gaps = [after - before for before, after in pairwise(ticks)]
    assert all(gap >= inhibit * 100 for gap in gaps)
    if period:
        assert all(gap <= max(inhibit * 100, period * 1000) for gap in gaps)
    last = next(level for _, level in reversed(jumps)) if jumps else 0
    assert sent[-1].frame.data == last.to_bytes(2, "little") + b"\0"
