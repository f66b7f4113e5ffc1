from dataclasses import FrozenInstanceError, dataclass, fields
from typing import Literal

import pytest

from canopen_twins.device.settings import about, changed, setting
from canopen_twins.errors import UserError


@dataclass(frozen=True)
class Example:
    count: int = setting(1, "a number of things", unit="pieces")
    ratio: float = setting(0.5, "a ratio", assumed="A-47", live=True)
    polite: bool = setting(True, "whether it greets")
    name: str = setting("nobody", "who it is")
    reaction: Literal["ignore", "abort"] = setting("ignore", "what it does")
    limit: int | None = setting(None, "where it ends")


def test_without_anything_given_the_defaults_hold():
    assert changed(Example(), {}) == Example()


def test_what_is_told_of_a_setting_can_be_listed():
    told = {entry.name: about(entry) for entry in fields(Example)}
    assert (told["count"].text, told["count"].unit) == ("a number of things", "pieces")
    assert (told["ratio"].assumed, told["ratio"].live) == ("A-47", True)
    assert (told["count"].assumed, told["count"].live) == ("", False)


def test_a_change_makes_new_settings_and_leaves_the_old_ones():
    before = Example()
    assert changed(before, {"count": 2}) == Example(count=2)
    assert before == Example()
    with pytest.raises(FrozenInstanceError):
        before.count = 2


@pytest.mark.parametrize(
    ("name", "given", "value"),
    [
        ("count", 7, 7),
        ("count", "0x1F", 31),
        ("count", 3.0, 3),
        ("ratio", 2, 2.0),
        ("ratio", "1e-3", 0.001),
        ("polite", False, False),
        ("polite", "off", False),
        ("polite", "Yes", True),
        ("name", "somebody", "somebody"),
        ("reaction", "abort", "abort"),
        ("limit", 5, 5),
        ("limit", "0x10", 16),
        ("limit", None, None),
        ("limit", "none", None),
    ],
)
def test_a_value_is_converted_to_the_type_of_its_setting(name, given, value):
    converted = getattr(changed(Example(), {name: given}), name)
    assert (converted, type(converted)) == (value, type(value))


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("count", 1.5),
        ("count", "many"),
        ("count", True),
        ("count", None),
        ("count", [1]),
        ("count", float("inf")),
        ("ratio", "nan"),
        ("ratio", float("inf")),
        ("ratio", False),
        ("polite", 2),
        ("polite", "perhaps"),
        ("reaction", "explode"),
        ("reaction", None),
        ("name", None),
        ("limit", "some"),
    ],
)
def test_a_value_of_another_kind_is_an_error_that_names_setting_and_value(name, given):
    with pytest.raises(UserError) as error:
        changed(Example(), {name: given})
    assert name in str(error.value)
    assert str(given) in str(error.value)


def test_an_unknown_setting_is_an_error_with_the_nearest_known_one():
    with pytest.raises(UserError, match=r"'raito'.*'ratio'"):
        changed(Example(), {"raito": 1})


def test_while_the_device_runs_only_live_settings_change():
    assert changed(Example(), {"ratio": 0.25}, live=True).ratio == 0.25
    with pytest.raises(UserError, match="power-on only"):
        changed(Example(), {"count": 2}, live=True)


def test_one_bad_setting_among_several_changes_none():
    with pytest.raises(UserError):
        changed(Example(), {"count": 2, "ratio": "much"})
