from canopen_twins.record.plot.track import Span, joined


def test_times_that_meet_or_overlap_are_one():
    spans = [Span(0, 1), Span(1, 3), Span(2, 2.5), Span(4, 4), Span(4, 5)]
    assert joined(spans) == [(0, 3), (4, 5)]
    assert joined([]) == []
