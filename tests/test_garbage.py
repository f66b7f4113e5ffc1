import gc
import weakref
from itertools import count

import pytest

from canopen_twins.bus.segment import Segment
from canopen_twins.live import garbage
from canopen_twins.live.serve import LONGEST_WAIT, drive


class Ring:
    """Garbage that only a search finds."""

    def __init__(self):
        self.itself = self


class QuietBus:
    def __init__(self):
        self.time = 0.0

    def receive(self, wait):
        self.time += wait


def old_garbage():
    """A ring nobody has any more, which has outlived the searches among younger objects."""
    ring = Ring()
    gc.collect(1)
    return weakref.ref(ring)


@pytest.fixture
def in_portions():
    with garbage.in_portions():
        yield


def drive_for(seconds, segment):
    bus = QuietBus()
    drive(segment, bus, lambda: bus.time > seconds, wall=lambda: bus.time)


def test_old_garbage_goes_while_the_bus_is_quiet(in_portions):
    lost = old_garbage()
    for _ in range(garbage.FEW):
        gc.collect(1)
    assert lost() is not None
    drive_for(2 * LONGEST_WAIT, Segment())
    assert lost() is None


def test_nobody_searches_where_something_is_due(in_portions):
    lost, segment = old_garbage(), Segment()
    segment.clock.every(LONGEST_WAIT / 2, lambda: None)
    for _ in range(garbage.FEW):
        gc.collect(1)
    drive_for(10 * LONGEST_WAIT, segment)
    assert lost() is not None


def test_in_a_process_of_somebody_else_python_searches_as_it_likes():
    before, lost = gc.get_threshold(), old_garbage()
    with garbage.in_portions():
        assert gc.get_threshold() != before
    assert gc.get_threshold() == before
    for _ in range(garbage.FEW):
        gc.collect(1)
    drive_for(2 * LONGEST_WAIT, Segment())
    assert lost() is not None


def test_a_search_in_the_middle_goes_through_few_objects(in_portions):
    kept, searched = [], []
    gc.callbacks.append(lambda phase, info: searched.append((phase, info["generation"])))
    try:
        for number in count():
            kept.append([number])
            if ("stop", 1) in searched:
                break
    finally:
        gc.callbacks.pop()
    assert len(kept) <= 3 * garbage.PORTIONS[0]
