from collections import Counter

import pytest

from canopen_twins import devices
from canopen_twins.conform import topics
from canopen_twins.conform.run import exemptions
from canopen_twins.scenario import Kind
from tools import conformance
from tools.proofs import shipped

GROUPS = {1: 1, 2: 30, 3: 33, 4: 9, 5: 6, 6: 10, 7: 20, 8: 10, 9: 4, 10: 4, 11: 12}


@pytest.fixture(scope="module")
def results():
    """What every topic gives with every device, and with the twin of a file."""
    return conformance.results()


def test_there_are_as_many_topics_as_in_the_conformance_test_and_those_of_lss():
    assert Counter(int(topic.number.split(".")[0]) for topic in topics()) == GROUPS
    assert sum(GROUPS.values()) == 127 + 12


def test_every_topic_says_what_it_is_about_and_where_that_stands():
    for topic in topics():
        assert topic.title[0].isupper() or topic.title[0].isdigit()
        assert topic.source.startswith("CiA 30"), topic


def test_no_twin_fails_a_topic(results):
    for outcomes in results.values():
        assert [str(each) for each in outcomes.values() if each.kind is Kind.FAIL] == []


@pytest.mark.parametrize("name", shipped())
def test_every_row_of_what_a_manual_wants_otherwise_is_needed(results, name):
    for number, exempt in exemptions(devices.create(name).eds).items():
        seen = f"not applicable: {exempt.reason} ({exempt.source})"
        assert results[name][number].seen == seen


def test_the_page_is_what_playing_the_topics_gives(results):
    assert conformance.PAGE.read_text("utf-8") == conformance.page(results), (
        "python -m tools.conformance writes it"
    )
