import pytest

from canopen_twins.files.shipped import scenarios


@pytest.mark.parametrize("name", scenarios())
def test_every_scenario_that_is_shipped_is_lived_through_again(said, tmp_path, name):
    code, out, _ = said("play", name, "--record", tmp_path / "record")
    assert code == 0
    trace = (tmp_path / "record" / "trace.log").read_text()
    assert out.startswith(trace)
    assert said("replay", tmp_path / "record")[:2] == (0, trace)
