import pytest
from hypothesis import given
from hypothesis.strategies import floats, lists, none, one_of

from canopen_twins.device.chart import Band, Mood
from canopen_twins.record.plot.track import MOST, Span, Track, extremes, joined, worst


def track_of(values, thin=extremes, period=0.001):
    track = Track(thin)
    for n, value in enumerate(values):
        track.add(n * period, value)
    return track


def test_only_changes_are_kept_so_that_rest_costs_nothing():
    assert track_of([0.0, 0.0, 5.0, 5.0, 5.0, None, None, 0.0]).points == [
        (0.0, 0.0),
        (0.002, 5.0),
        (0.005, None),
        (0.007, 0.0),
    ]


def test_a_spike_of_a_millisecond_survives_an_hour():
    values = [n % 7 for n in range(100_000)]
    values[77_777], values[12_345] = 1000, -1000
    points = track_of(values, period=0.036).points
    assert len(points) <= MOST
    assert (77_777 * 0.036, 1000) in points
    assert (12_345 * 0.036, -1000) in points


def test_a_gap_survives():
    values = [n % 7 for n in range(50_000)]
    values[33_333] = None
    assert (33.333, None) in track_of(values).points


def test_thinned_or_not_it_begins_and_ends_where_it_did():
    points = track_of([n % 3 for n in range(30_000)], period=0.25).points
    assert (points[0], points[-1]) == ((0.0, 0), (29_999 / 4, 29_999 % 3))
    assert [point.time for point in points] == sorted({point.time for point in points})


@pytest.mark.parametrize("count", [MOST, MOST + 1, 2 * MOST, 2 * MOST + 1, 5 * MOST])
def test_there_are_never_too_many_points(count):
    points = track_of(range(count)).points
    assert len(points) <= MOST
    assert points[-1].value == count - 1


@given(lists(one_of(none(), floats(allow_nan=False)), min_size=1))
def test_what_is_left_of_a_part_tells_its_extremes_and_how_it_ends(values):
    kept = extremes(track_of(values).points)
    left = [point.value for point in kept if point.value is not None]
    given_ = [value for value in values if value is not None]
    assert len(kept) <= 4
    assert (min(left, default=0), max(left, default=0)) == (
        min(given_, default=0),
        max(given_, default=0),
    )
    assert kept[-1].value == values[-1]
    assert (None in values) is any(point.value is None for point in kept)


def test_of_many_states_the_worst_is_seen():
    good, bad = Band("run", Mood.ACTIVE), Band("error", Mood.ERROR)
    other = Band("ready", Mood.WAITING)
    states = [(good, other)[n % 2] for n in range(20_000)]
    states[11_111] = bad
    points = track_of(states, worst).points
    assert len(points) <= MOST
    assert bad in [point.value for point in points]
    assert points[-1].value == states[-1]


def test_times_that_meet_or_overlap_are_one():
    spans = [Span(0, 1), Span(1, 3), Span(2, 2.5), Span(4, 4), Span(4, 5)]
    assert joined(spans) == [(0, 3), (4, 5)]
    assert joined([]) == []
