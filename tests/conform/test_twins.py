import pytest

from canopen_twins import devices
from canopen_twins.conform import conform_twin
from canopen_twins.scenario import Kind

TWINS = [*devices.names(), "docs/examples/battery/battery.device.yaml"]


@pytest.mark.parametrize("name", TWINS)
def test_a_twin_fails_no_topic(name):
    verdict = conform_twin(name, devices.create(name, node_id=5))
    assert [str(each) for each in verdict.outcomes if each.kind is Kind.FAIL] == []
