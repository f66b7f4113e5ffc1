import pytest

from tests.compare.test_local_node import WITH_A_DIFFERENCE, differences
from tests.vcan.bus import CHANNEL

pytestmark = pytest.mark.vcan


def test_what_a_local_node_does_otherwise_is_found(tmp_path):
    found = differences({"interface": "socketcan", "channel": CHANNEL}, tmp_path)
    lacking = [why for why, words in WITH_A_DIFFERENCE if not any(words in each for each in found)]
    assert lacking == []
