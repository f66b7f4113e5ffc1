import pytest

from canopen_twins import Bench, UserError


@pytest.fixture
def bench():
    return Bench("topcon", node_id=5)


def test_settings_refused_at_power_on_leave_everything_as_it_was(bench):
    bench.power_off()
    with pytest.raises(UserError, match="node id 128"):
        bench.power_on(node_id=128, serial=7)
    bench.power_on()
    assert bench.sent == ["705#00", "705#00"]
    assert bench.sdo["Identity Object"]["Serial number"].raw == 1


def test_settings_wait_for_the_power_to_be_off(bench):
    with pytest.raises(UserError, match="the power is on: switch it off"):
        bench.power_on(serial=7)
    bench.power_on()  # on already
    assert bench.sent == ["705#00"]
    bench.power_off()
    bench.power_on(serial=7)
    assert bench.sdo["Identity Object"]["Serial number"].raw == 7
