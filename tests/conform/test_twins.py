from collections import Counter

import pytest

from canopen_twins import devices
from canopen_twins.conform import conform_twin, topics
from canopen_twins.conform.run import exemptions
from canopen_twins.scenario import Kind

GROUPS = {1: 1, 2: 30, 3: 33, 4: 9, 5: 6, 6: 10, 7: 20, 8: 10, 9: 4, 10: 4, 11: 12}


def test_there_are_as_many_topics_as_in_the_conformance_test_and_those_of_lss():
    assert Counter(int(topic.number.split(".")[0]) for topic in topics()) == GROUPS
    assert sum(GROUPS.values()) == 127 + 12


@pytest.mark.parametrize("name", devices.names())
def test_a_device_fails_no_topic_but_what_its_manual_wants_otherwise(name):
    device = devices.create(name, node_id=5)
    verdict = conform_twin(name, device)
    failed = [str(each) for each in verdict.outcomes if each.kind is Kind.FAIL]
    assert failed == []
    for number, exempt in exemptions(device.eds).items():
        (outcome,) = [each for each in verdict.outcomes if each.topic == number]
        assert outcome.seen == f"not applicable: {exempt.reason} ({exempt.source})"
