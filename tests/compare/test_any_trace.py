"""Jitter, lost lines, traffic of others, a start in the middle: no difference that is none."""

from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from canopen_twins import Bench, devices
from canopen_twins.bus.clock import microseconds
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Record
from canopen_twins.errors import UserError
from canopen_twins.record.compare import Allowed, Comparison, Tolerances
from canopen_twins.record.compare.report import text
from canopen_twins.record.trace_reader import Trace

from .conftest import compared, told, traced
from .local_node import BLOCK
from .masters import Master, supply

FEW = settings(max_examples=4, phases=[Phase.generate])  # a trace of a seed does not shrink
OTHERS = ["701#05", "186#1122334455667788", "306#01", "606#4000100000000000", "586#43", "18FF#01"]
OTHERS[-1] = "18FF0102#0102"


@cache
def original():
    return tuple(traced(supply))


def jitter(records, chance, seconds=0.002):
    """Frames of the device come later, as a device and a sniffer have it, and none overtakes."""
    late, last = [], 0.0
    for record in records:
        time = record.time + (chance.uniform(0, seconds) if record.sender else 0.0)
        last = max(last, time)
        late.append(record._replace(time=last))
    return late


def with_others(records, chance):
    """Frames of other nodes in between."""
    for record in records:
        if chance.random() < 0.3:
            yield Record(record.time, Frame.parse(chance.choice(OTHERS)), "")
        yield record


def losing(records, chance, share=0.05):
    """Lines that the sniffer has not written: answers, TPDOs, heartbeats, and questions."""
    for record in records:
        text = str(record.frame)
        lost = record.sender or text.startswith("605#40")
        if not (lost and chance.random() < share and text != "705#00"):
            yield record


@FEW
@given(st.integers(0, 1000))
def test_jitter_and_others_are_no_difference(seed):
    chance = Random(seed)
    agreement = compared(list(with_others(jitter(original(), chance), chance)))
    assert (told(agreement), agreement.share) == ([], 1.0)


SHIFTED = Allowed(digits=20)  # what was set without an answer acts some milliseconds later


@cache
def leisurely():
    return tuple(traced(partial(supply, pause=0.012)))


@FEW
@given(st.integers(0, 1000))
def test_of_lost_lines_nothing_but_themselves_is_told(seed):
    chance = Random(seed)
    records = list(losing(jitter(leisurely(), chance), chance))
    lost = len(leisurely()) - len(records)
    agreement = compared(records, tolerances=Tolerances(value=SHIFTED))
    alone = sum(each.count for each in agreement.differences.values())
    assert {each.kind.name for each in agreement.differences.values()} <= {"LACKS", "MORE"}
    assert alone <= 2 * lost
    forgiving = compared(records, tolerances=Tolerances(value=SHIFTED, lost=0.2))
    assert (told(forgiving), forgiving.share) == ([], 1.0)


def going(bench):
    """A supply that was set up long ago: it is asked and synchronised, again and again."""
    master = Master(bench)
    master.wait_for_boot_up() if not bench.trace else None
    master.write(0x1017, 0, 50)
    master.write(0x2031, 0, 3000)
    master.nmt(0x01)
    bench.trace.clear()
    for _ in range(6):
        master.read((0x1017, 0), (0x2031, 0), (0x2020, 0), (0x1008, 0))
        master.send(0x180, "R")
        master.run(0.03)


@FEW
@given(st.integers(0, 60), st.integers(0, 1000))
def test_a_trace_may_begin_anywhere(first, seed):
    records = jitter(traced_going(), Random(seed))[first:]
    agreement = compared(records)
    assert (told(agreement), agreement.share) == ([], 1.0)
    assert "begins in the middle" in agreement.remarks[0]


@cache
def traced_going():
    return tuple(traced(going))


def test_what_only_the_device_may_change_is_found_in_the_middle_too():
    agreement = compared(traced(going, serial=7, firmware="V4.11.20", unit="TCP-16-100"))
    assert told(agreement) == []  # none of it is asked for
    asked = traced(lambda bench: (going(bench), Master(bench).read((0x1018, 4))), serial=7)
    assert told(compared(asked)) == ["SDO 0x1018:04 Identity Object.Serial number: another value"]


def test_a_recording_may_pause_and_its_clock_may_be_set():
    records = list(traced_going())
    half = len(records) // 2
    for leap in (7200.0, -30.0):
        leaping = [each._replace(time=each.time + 40 + leap) for each in records[half:]]
        first = [each._replace(time=each.time + 40) for each in records[:half]]
        agreement = compared([*first, *leaping])
        assert agreement.share == 1.0
        assert "left out" in agreement.remarks[1] or "goes back" in agreement.remarks[1]


def test_two_nodes_of_one_bus_are_compared_at_once():
    bench = Bench.of({"left": ("topcon", 5), "right": ("charger", 6)})
    for base, node in (("605", 5), ("606", 6)):
        bench.send(f"{base}#2B17100064000000")
        bench.send(f"000#01{node:02X}")
    bench.run(1.2)
    bench.send("605#4000200000000000")
    bench.send("606#4018100200000000")
    nodes = {
        "left": devices.create("topcon", node_id=5, unit="TCP-16-100"),
        "right": devices.create("charger", node_id=6, product_code=2),
    }
    comparison = Comparison(nodes)
    for record in bench.trace:
        comparison.hear(microseconds(record.time), record.frame)
    found = comparison.end().differences.values()
    assert [(each.subject.node, each.subject.object) for each in found] == [
        ("left", "0x2000:00 Nominal voltage"),
        ("right", "0x1018:02 Identity Object.Product Code"),
    ]


COMMANDS = bytes.fromhex("402F2B236070414B4F43001001802180A4C2C6A1A3C1")
OBJECTS = [0x1000, 0x1008, 0x1010, 0x1017, 0x1018, 0x1800, 0x2010, 0x2020, 0x6000]
OF_THE_NODE = [0x605, 0x585, 0x605, 0x585, 0x705, 0x085, 0x185, 0x205, 0x7E4, 0x7E5, 0x000, 0x080]


def nonsense(chance):
    """Frames of every service, right and wrong, in any order."""
    tick = 0
    for _ in range(chance.randrange(20, 120)):
        tick += chance.choice([0, 10, 500, 3000, 20_000, 200_000, 2_000_000])
        can_id = chance.choice(OF_THE_NODE)
        data = bytearray(chance.randbytes(chance.choice([8, 8, 8, 1, 2, 0])))
        if can_id in (0x605, 0x585) and len(data) == 8:
            data[0] = chance.choice(COMMANDS)
            data[1:4] = chance.choice(OBJECTS).to_bytes(2, "little") + bytes([chance.randrange(3)])
        if can_id == 0 and len(data) > 1:
            data[:2] = bytes([chance.choice([1, 2, 0x80, 0x81, 0x82]), chance.choice([0, 5])])
        yield tick, Frame(can_id, bytes(data), chance.random() < 0.05)


@settings(max_examples=20, phases=[Phase.generate])
@given(st.integers(0, 10_000), st.sampled_from(["topcon", "charger", "gateway", str(BLOCK)]))
def test_whatever_is_in_a_trace_there_is_something_to_say_about_it(seed, device):
    chance = Random(seed)
    timing = chance.choice(["ideal", "typical", "worst"])
    comparison = Comparison({"twin": devices.create(device, node_id=5, timing=timing)})
    for tick, frame in nonsense(chance):
        comparison.hear(tick, frame)
    with suppress(UserError):
        agreement = comparison.end()
        assert 0 <= agreement.share <= 1
        assert text(agreement)


@settings(max_examples=60, phases=[Phase.generate])
@given(
    st.sampled_from([".log", ".asc", ".trc"]), st.text() | st.text("()0123456789ABCDEF.# can0Rxd")
)
def test_whatever_stands_in_a_file_is_a_frame_or_damaged(suffix, content):
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"any{suffix}"
        path.write_text(content, "utf-8")
        with suppress(UserError):
            list(Trace(path))
