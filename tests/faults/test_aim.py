import pytest

from canopen_twins import UserError
from canopen_twins.faults.disturbance import Aim


def struck(aim, length=12):
    """What is struck of a row, as a text."""
    return "".join("x" if aim.strikes() else "." for _ in range(length))


@pytest.mark.parametrize(
    ("given", "row"),
    [
        ({}, "xxxxxxxxxxxx"),
        ({"nth": 3}, "..xxxxxxxxxx"),
        ({"times": 2}, "xx.........."),
        ({"nth": 4, "times": 1}, "...x........"),
        ({"probability": 0}, "............"),
        ({"probability": 0, "burst": 3}, "............"),
        ({"burst": 5, "times": 2}, "xx.........."),
    ],
)
def test_it_is_counted(given, row):
    assert struck(Aim(**given)) == row


def test_it_is_over_when_all_have_been_struck_and_never_before():
    aim = Aim(nth=2, times=2)
    assert [(aim.strikes(), aim.over) for _ in range(4)] == [
        (False, False),
        (True, False),
        (True, True),
        (False, True),
    ]
    assert not Aim().over


def test_chance_is_the_seed_s():
    rows = {seed: struck(Aim(probability=0.5, seed=seed), 100) for seed in range(20)}
    assert rows == {seed: struck(Aim(probability=0.5, seed=seed), 100) for seed in range(20)}
    assert len(set(rows.values())) == 20
    assert 900 < sum(row.count("x") for row in rows.values()) < 1100


def test_a_burst_goes_on_where_chance_has_begun_it():
    row = struck(Aim(probability=0.1, burst=4), 1000)
    runs = [run for run in row.split(".") if run]
    assert runs
    assert all(len(run) % 4 == 0 for run in runs[:-1])
    assert row.count("x") > 200


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"nth": 0}, "parameter 'nth' of fault 'sdo_silence': 0 is less than 1"),
        ({"times": -1}, "parameter 'times' of fault 'sdo_silence': -1 is less than 0"),
        ({"probability": 1.5}, "1.5 is more than 1"),
        ({"seed": 0.5}, "'seed' of fault 'sdo_silence' wants a whole number, not 0.5"),
        ({"object": 1.5}, "'object' of fault 'sdo_silence' wants a number or a text, not 1.5"),
        ({"object": True}, "'object' of fault 'sdo_silence' wants a number or a text, not True"),
        ({"object": 0x10000}, "0x10000 is no index"),
        ({"object": "Actual voltag"}, "did you mean 'Actual voltage'?"),
        ({"access": "reed"}, "unknown access 'reed': did you mean 'read'?"),
    ],
)
def test_what_cannot_be_is_refused_in_words_and_nothing_is_injected(topcon, active, given, message):
    with pytest.raises(UserError) as refusal:
        topcon.inject("sdo_silence", **given)
    assert message in str(refusal.value)
    assert active() == []
