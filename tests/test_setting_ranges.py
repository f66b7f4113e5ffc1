from dataclasses import dataclass

import pytest

from canopen_twins import UserError
from canopen_twins.cli import main
from canopen_twins.device.settings import about, changed, setting


@dataclass(frozen=True)
class Settings:
    switch: int | None = setting(None, "a rotary switch", low=0, high=15)
    time: float = setting(1.0, "a time", unit="s", low=0)
    offset: float = setting(0.0, "anything")


@pytest.mark.parametrize("given", [{"switch": 0}, {"switch": "15"}, {"time": 0}, {"switch": None}])
def test_a_number_inside_its_range_is_taken(given):
    assert changed(Settings(switch=3), given) != Settings(switch=3)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"switch": 16}, "setting 'switch' is 0 to 15, not 16"),
        ({"switch": "-1"}, "setting 'switch' is 0 to 15, not -1"),
        ({"time": -0.5}, "setting 'time' is 0 or more, not -0.5"),
    ],
)
def test_a_number_outside_its_range_is_refused_in_words(given, message):
    with pytest.raises(UserError) as refusal:
        changed(Settings(), given)
    assert str(refusal.value) == message


def test_a_number_without_a_range_is_any():
    assert changed(Settings(), {"offset": -1e9}).offset == -1e9
    fields = Settings.__dataclass_fields__.values()
    assert [about(field).range for field in fields] == ["0 to 15", "0 or more", ""]


def test_the_range_of_a_setting_is_listed(capsys):
    assert main(["settings", "topcon"]) == 0
    told = capsys.readouterr().out
    assert "switch BR, the bit rate (4.3), 0 to 15; may change while running" in told
    assert "from power-on until RUN works [s], 0 or more" in told
