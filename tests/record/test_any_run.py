from itertools import count

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from canopen_twins import devices
from canopen_twins.bench.twin import carry_out
from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.faults import connect
from canopen_twins.record.differences import Side, differences
from canopen_twins.record.folder import Recorded, record, reproduce
from canopen_twins.record.manifest import Manifest

FRAMES = [
    "000#0105",
    "000#8205",
    "000#8105",
    "080#",
    "185#R",
    "205#0100D00700000000",
    "605#2B17100001000000",
    "605#2F00180201000000",
    "605#2310100173617665",
    "605#4018100400000000",
    "705#R",
    "605#",
    "18FEF105#",
]
DELAYS = st.one_of(st.just(0), st.integers(1, 2000), st.integers(0, 500_000))
STALLS = st.sampled_from([0, 0, 0, 1, 5_000, 50_000, 700_000])  # microseconds that are made up for
ORDERS = [("power_off",), ("power_on", {}), ("inject", "bus_load", {}), ("clear", None)]
EVENTS = st.sampled_from([*FRAMES, *ORDERS])
RUNS = st.lists(st.tuples(DELAYS, STALLS, EVENTS), max_size=15)
number = count()


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sampled_from(devices.names()), RUNS, DELAYS)
def test_whatever_comes_and_when_and_however_late_the_replay_is_the_same(tmp_path, name, run, rest):
    folder = tmp_path / str(next(number))
    device = devices.create(name, node_id=5)
    told = Manifest.of("run", None, {name: device})
    with record(folder, told, None) as observer:
        segment = Segment()
        clock = segment.clock
        node = connect(segment, device, name)
        observer(segment, None)
        node.power_on()
        segment.deliver()
        for delay, stall, event in run:
            segment.advance(delay / MICROSECONDS)
            clock.unseen = max(clock.unseen, clock.ticks + stall)  # it never goes back
            segment.advance(0)
            if isinstance(event, str):
                segment.send(Frame.parse(event))
            else:
                carry_out(segment, node, *event)
            segment.advance(0)
        segment.advance(rest / MICROSECONDS)
    anew = folder.with_suffix(".anew")
    with record(anew, told, None) as observer:
        reproduce(Recorded(folder), [observer])
    same, words = differences(Side.of("record", folder), Side.of("replay", anew))
    assert same, words
    assert (folder / "trace.log").read_bytes() == (anew / "trace.log").read_bytes()
