from hypothesis import given
from hypothesis.strategies import floats, lists, text, tuples

from canopen_twins.record.plot.figure import label, rows
from canopen_twins.record.plot.look import AXIS, MOST_ROWS

PLACES = floats(0, AXIS)
BARS = lists(tuples(text("abc", min_size=1, max_size=40), PLACES, PLACES))


def labels_of(bars):
    """In the order of their times, as they are drawn."""
    in_order = sorted((*sorted(ends), text) for text, *ends in bars)
    return [label(text, start, end) for start, end, text in in_order]


@given(BARS)
def test_no_label_lies_upon_another(bars):
    labels = labels_of(bars)
    told = zip(rows(labels), labels, strict=True)
    placed = [(row, each) for row, each in told if row < MOST_ROWS]
    for at, (row, one) in enumerate(placed):
        for other_row, other in placed[:at]:
            assert row != other_row or other.right <= one.left or one.right <= other.left


@given(BARS)
def test_no_label_leaves_the_axis_on_the_right(bars):
    for each in labels_of(bars):
        assert each.right <= AXIS


def test_a_label_stands_in_its_bar_or_beside_it():
    inside, beside, before = label("mains", 1, 4), label("mains", 1, 1.1), label("mains", 9, AXIS)
    assert 1 < inside.at < 4
    assert beside.at > 1.1
    assert not beside.flipped
    assert before.flipped
    assert before.at < 9


def test_where_there_is_room_no_label_goes_without_a_row():
    crowd = [label("mains", 1 + n / 100, 1 + n / 100) for n in range(MOST_ROWS + 1)]
    assert rows(crowd) == list(range(MOST_ROWS + 1))
    assert rows([*crowd, label("mains", 5, 5)])[-1] == 0
