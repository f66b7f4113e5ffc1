"""Protocol level, PDO: what a node sends of its process data goes wrong."""

from collections.abc import Mapping

from canopen_twins.bus.frame import LONGEST, STANDARD_IDS, Frame
from canopen_twins.device.faults import Parameter
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.faults.disturbance import (
    AIM,
    Filtering,
    Fits,
    Kind,
    Place,
    Turn,
    altered,
    frozen,
    jittered,
    lost,
    renamed,
)
from canopen_twins.slave import cob_id as cob_ids
from canopen_twins.slave.slave import Slave
from canopen_twins.slave.tpdo import Tpdo

TPDO = {"number": Parameter("which TPDO, counted from 1; 0: all of them", 0, int, low=0, high=512)}


def tpdo(place: Place, number: int) -> Fits:
    """The frames of a TPDO, or of all of them.

    Raises:
        UserError: the device has no TPDO of this number.
    """
    if number and Tpdo.communication + number - 1 not in place.node.device.dictionary():
        raise UserError(f"the device has no TPDO {number}")

    def fits(node: Node, frame: Frame) -> bool:
        slave = node.slave
        if slave is None or frame.remote:
            return False
        numbers = [number] if number else Tpdo.numbers(slave)
        return any(_id(slave, each) == frame.can_id for each in numbers)

    return fits


def _id(slave: Slave, number: int) -> int | None:
    value = slave.number(Tpdo.communication + number - 1, 1)
    return None if value & cob_ids.INVALID else value & cob_ids.CAN_ID


PDO: Mapping[str, Kind] = {
    "pdo_frozen": Kind(
        "A TPDO goes on with the data it had when it was struck first.",
        "Values that never change: set and actual value part, an answer to a command is missing.",
        {**TPDO, **AIM},
        lambda place, number, **turn: Filtering(
            place.node, tpdo(place, number), frozen(), Turn(**turn)
        ),
    ),
    "pdo_missing": Kind(
        "A TPDO does not come.",
        "Silence on its identifier: a time-out of the consumer, not old values.",
        {**TPDO, **AIM},
        lambda place, number, **turn: Filtering(
            place.node, tpdo(place, number), lost, Turn(**turn)
        ),
    ),
    "pdo_short": Kind(
        "A TPDO is shorter than its mapping.",
        "A length error: no value of it may be used (CiA 301, 7.2.2.5).",
        {"missing": Parameter("bytes at its end", 1, int, low=1, high=LONGEST), **TPDO, **AIM},
        lambda place, number, missing, **turn: Filtering(
            place.node, tpdo(place, number), altered(lambda data: data[:-missing]), Turn(**turn)
        ),
    ),
    "pdo_wrong_cob_id": Kind(
        "A TPDO comes with another identifier.",
        "Silence on its identifier, and a frame that nobody knows, or that is taken for another.",
        {
            "cob_id": Parameter("the identifier it has", 0x57F, int, low=1, high=STANDARD_IDS[-1]),
            **TPDO,
            **AIM,
        },
        lambda place, number, cob_id, **turn: Filtering(
            place.node, tpdo(place, number), renamed(cob_id), Turn(**turn)
        ),
    ),
    "pdo_jitter": Kind(
        "A TPDO comes late, each time by another time; none overtakes another.",
        "Cycles that are too short and too long: no alarm below the limit, one above.",
        {"seconds": Parameter("at most by how much, in s", 0.01, low=0), **TPDO, **AIM},
        lambda place, number, seconds, **turn: Filtering(
            place.node,
            tpdo(place, number),
            jittered(place.node.clock, seconds, turn["seed"]),
            Turn(**turn),
        ),
    ),
}
