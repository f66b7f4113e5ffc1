import pytest

from canopen_twins.errors import unknown


@pytest.mark.parametrize(
    ("word", "known", "hint"),
    [
        ("resistr", ["open", "resistor"], "did you mean 'resistor'?"),
        ("tree", ["open", "resistor"], "there is open, resistor"),
        ("tree", [], "there is none"),
        ("tree", [f"object {n}" for n in range(90)], "there are 90, none of them near"),
    ],
)
def test_an_unknown_word_comes_with_a_hint_of_one_line(word, known, hint):
    assert str(unknown("load", word, known)) == f"unknown load {word!r}: {hint}"
