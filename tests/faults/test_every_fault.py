import re
from pathlib import Path

import pytest

from canopen_twins import Bench, devices
from canopen_twins.device.faults import Fault
from canopen_twins.faults import AIM, LEVELS

from .conftest import READ_VERSION, READ_VOLTAGE, START, SYNC

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "faults.md"
KINDS = {name: kind for kinds in LEVELS.values() for name, kind in kinds.items()}
WANTED = {"frame_swapped": {"frame": "585#*"}}
CHANCES = [name for name, kind in KINDS.items() if "probability" in kind.parameters]
SUPPLY = ["reset_loop", "power_cycle", "brown_out"]

every_fault = pytest.mark.parametrize("name", KINDS)


def talk(bench, seconds=1.0):
    """Something of everything a master does, without changing anything."""
    for _ in range(3):
        for text in (READ_VOLTAGE, READ_VERSION, "605#6000000000000000", "605#7000000000000000"):
            bench.send(text)
        bench.send(SYNC)
        bench.run(seconds / 3)


def trace(bench, since):
    return [str(record) for record in bench.trace if record.time >= since]


def story(bench, name, after):
    """A fault from 0 s to 2 s; the trace from there on."""
    if name:
        bench.inject(name, **WANTED.get(name, {}))
    talk(bench)
    bench.run(1.0)
    bench.clear()
    bench.trace.clear()
    after(bench)
    bench.inject("lasting_error", number=0x23)
    talk(bench, 7.0)
    bench.clear()
    return [str(record) for record in bench.trace]


def start_anew(bench):
    bench.power_off()
    bench.power_on()
    bench.sdo["Producer Heartbeat Time"].raw = 70
    bench.send(START)


@pytest.fixture
def another() -> Bench:
    bench = Bench("topcon", node_id=5)
    bench.sdo["Producer Heartbeat Time"].raw = 100
    bench.sdo[0x1800][2].raw = 1
    bench.send(START)
    return bench


@every_fault
def test_it_leaves_no_trace_once_it_is_cleared(topcon, another, name):
    after = start_anew if name in SUPPLY else lambda bench: None
    assert story(topcon, name, after) == story(another, None, after)
    wire = topcon.twin.node.wire
    assert (wire.incoming, wire.outgoing) == ([], [])
    assert topcon.segment.nodes == [topcon.twin.node]


@every_fault
def test_it_is_listed_while_it_is_active(topcon, active, name):
    topcon.inject(name, **WANTED.get(name, {}))
    assert active() == [name]
    topcon.clear(name)
    assert active() == []


@pytest.mark.parametrize("name", CHANCES)
def test_the_same_seed_gives_the_same_frames(topcon, another, name):
    for bench in (topcon, another):
        bench.inject(name, **WANTED.get(name, {}), probability=0.5, seed=7)
        bench.inject("error", number=0x23)
        talk(bench)
    assert trace(topcon, 0.0) == trace(another, 0.0)


@every_fault
def test_it_may_be_injected_into_a_device_without_power(topcon, name):
    topcon.power_off()
    topcon.inject(name, **WANTED.get(name, {}))
    topcon.run(1.0)
    topcon.power_on()
    topcon.run(1.0)
    topcon.clear()
    topcon.power_off()
    assert topcon.run(10.0) == []


def test_all_of_them_at_once_leave_no_trace_either(topcon, another):
    for name in KINDS:
        topcon.inject(name, **WANTED.get(name, {}))
    talk(topcon)
    talk(another)
    for bench in (topcon, another):
        bench.clear()
        bench.trace.clear()
        start_anew(bench)
        talk(bench)
    assert trace(topcon, 0.0) == trace(another, 0.0)


@pytest.mark.parametrize("device", devices.names())
def test_every_device_has_them_beside_its_own(device):
    bench = Bench(device)
    known = bench.twin.node.faults.known
    assert set(known) == {*KINDS, *bench.device.faults}
    assert len(known) >= 30


def test_a_device_cannot_have_one_of_their_names():
    probe = devices.create("topcon", node_id=5)

    class Rival(type(probe)):
        @property
        def faults(self):
            return {"bus_off": Fault("mine", lambda: None)}

    with pytest.raises(ValueError, match="every device has a fault 'bus_off': name yours"):
        Bench.of({"rival": Rival(node_id=5)})


def row(name, kind):
    own = [key for key, told in kind.parameters.items() if AIM.get(key) is not told]
    parameters = ", ".join(f"`{key}`" for key in own)
    aim = " +" if len(own) < len(kind.parameters) else ""
    return f"| `{name}` | {parameters}{aim} | {kind.text} | {kind.sees} |"


def test_the_page_has_every_fault_as_the_table_has_it():
    rows = re.findall(r"^\| `.*$", PAGE.read_text("utf-8"), re.MULTILINE)
    assert rows == [row(name, kind) for name, kind in KINDS.items()]


def test_every_one_says_what_it_does_and_what_the_master_should_see():
    for name, kind in KINDS.items():
        assert kind.text.endswith("."), name
        assert kind.sees.endswith("."), name
        assert all(told.text for told in kind.parameters.values()), name
