import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from canopen_twins import Bench, devices
from canopen_twins.bus.frame import Frame
from canopen_twins.diagnosis.expected import ExpectedEmcy, ExpectedFrame, ExpectedHeartbeat
from canopen_twins.diagnosis.why import TOLD, why

NODE_ID = 5
IDS = [0x000, 0x080, *(base + NODE_ID for base in range(0x080, 0x780, 0x080)), 0x7E5]
FAULTS = ["sdo_silence", "sdo_late", "sdo_wrong_size", "frame_lost", "frame_corrupt", "bus_off"]

frames = st.builds(
    Frame, st.sampled_from(IDS), st.binary(max_size=8), remote=st.sampled_from([False, False, True])
)


def values(node):
    """Everything in the dictionary of a node, nothing of one that is silent."""
    subs = node.slave.entries.values() if node.slave else []
    return [entry.read() for entries in subs for entry in entries.values()]


@pytest.mark.parametrize("device", devices.names())
@settings(max_examples=25)
@given(
    st.lists(st.one_of(frames, st.sampled_from(FAULTS), st.sampled_from([0.01, 0.3])), max_size=25),
    st.sampled_from([None, ExpectedFrame(0x185), ExpectedEmcy(), ExpectedHeartbeat()]),
)
def test_whatever_happens_it_is_told_in_lines_and_changes_nothing(device, story, expected):
    bench = Bench(device, node_id=NODE_ID)
    bench.run(0.5)
    for event in story:
        if isinstance(event, Frame):
            bench.put(event)
        elif isinstance(event, str):
            bench.inject(event)
        else:
            bench.run(event)
    node, sent = bench.twin.node, len(bench.trace)
    before = values(node)
    lines = why(node, bench.trace, expected=expected)
    assert len(lines) <= TOLD + 2
    assert all(line and "\n" not in line for line in lines)
    assert why(node, bench.trace, expected=expected) == lines
    assert (values(node), len(bench.trace)) == (before, sent)
