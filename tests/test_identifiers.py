"""The predefined connection set, CiA 301, tables 39 and 40."""

import pytest

from canopen_twins.bus import identifiers
from canopen_twins.bus.identifiers import Cob, classify


@pytest.mark.parametrize(
    ("can_id", "cob"),
    [
        (0x000, Cob.NMT),
        (0x080, Cob.SYNC),
        (0x100, Cob.TIME),
        (0x7E4, Cob.LSS_ANSWER),
        (0x7E5, Cob.LSS_REQUEST),
    ],
)
def test_identifiers_of_the_whole_bus(can_id, cob):
    assert classify(can_id) == (cob, 0)


@pytest.mark.parametrize(
    ("first", "last", "cob"),
    [
        (0x081, 0x0FF, Cob.EMCY),
        (0x181, 0x1FF, Cob.TPDO),
        (0x201, 0x27F, Cob.RPDO),
        (0x281, 0x2FF, Cob.TPDO),
        (0x301, 0x37F, Cob.RPDO),
        (0x381, 0x3FF, Cob.TPDO),
        (0x401, 0x47F, Cob.RPDO),
        (0x481, 0x4FF, Cob.TPDO),
        (0x501, 0x57F, Cob.RPDO),
        (0x581, 0x5FF, Cob.SDO_ANSWER),
        (0x601, 0x67F, Cob.SDO_REQUEST),
        (0x701, 0x77F, Cob.HEARTBEAT),
    ],
)
def test_identifiers_of_one_node(first, last, cob):
    assert (classify(first), classify(last)) == ((cob, 1), (cob, 127))


@pytest.mark.parametrize("can_id", [0x001, 0x07F, 0x101, 0x180, 0x200, 0x580, 0x680, 0x780, 0x7FF])
def test_identifiers_of_nobody(can_id):
    assert classify(can_id) is None


def test_what_a_node_has_for_itself():
    assert identifiers.emcy(5) == 0x085
    assert identifiers.sdo_request(5) == 0x605
    assert identifiers.sdo_answer(5) == 0x585
    assert identifiers.heartbeat(5) == 0x705
