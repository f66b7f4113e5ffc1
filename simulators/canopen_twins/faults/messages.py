"""Protocol and node level: PDO, EMCY, heartbeat and boot-up message, as a node sends them."""

from collections.abc import Mapping
from typing import Any

from canopen_twins.bus import identifiers
from canopen_twins.bus.frame import LONGEST, STANDARD_IDS, Frame
from canopen_twins.device.faults import Parameter
from canopen_twins.device.node import Node
from canopen_twins.errors import UserError
from canopen_twins.faults.disturbance import (
    AIM,
    Disturbance,
    Effect,
    FaultType,
    Filtering,
    Fits,
    Place,
    altered,
    doubled,
    frozen,
    jittered,
    late,
    lost,
    renamed,
    repeated,
)
from canopen_twins.slave.emcy import FIELD_LENGTH, Emcy, emcy_data, emcy_id
from canopen_twins.slave.nmt import BOOT_UP
from canopen_twins.slave.service import State
from canopen_twins.slave.tpdo import Tpdo

TPDO = {"number": Parameter("which TPDO, counted from 1; 0: all of them", 0, int, low=0, high=512)}


def tpdo(place: Place, number: int) -> Fits:
    """The frames of a TPDO, or of all of them.

    Raises:
        UserError: the device has no TPDO of this number.
    """
    if number and Tpdo.communication + number - 1 not in place.node.dictionary:
        raise UserError(f"the device has no TPDO {number}")

    def fits(node: Node, frame: Frame) -> bool:
        slave = node.slave
        if slave is None or frame.remote:
            return False
        numbers = [number] if number else Tpdo.numbers(slave)
        return any(Tpdo.identifier(slave, each) == frame.can_id for each in numbers)

    return fits


PDO: Mapping[str, FaultType] = {
    "pdo_frozen": FaultType(
        "A TPDO goes on with the data it had when it was struck first.",
        "Values that never change: set and actual value part, an answer to a command is missing.",
        {**TPDO, **AIM},
        lambda place, number, **aim: Filtering(place, tpdo(place, number), frozen(), **aim),
    ),
    "pdo_missing": FaultType(
        "A TPDO does not come.",
        "Silence on its identifier: a time-out of the consumer, not old values.",
        {**TPDO, **AIM},
        lambda place, number, **aim: Filtering(place, tpdo(place, number), lost, **aim),
    ),
    "pdo_short": FaultType(
        "A TPDO is shorter than its mapping.",
        "A length error: no value of it may be used (CiA 301, 7.2.2.5).",
        {"missing": Parameter("bytes at its end", 1, int, low=1, high=LONGEST), **TPDO, **AIM},
        lambda place, number, missing, **aim: Filtering(
            place, tpdo(place, number), altered(lambda data: data[:-missing]), **aim
        ),
    ),
    "pdo_wrong_cob_id": FaultType(
        "A TPDO comes with another identifier.",
        "Silence on its identifier, and a frame that nobody knows, or that is taken for another.",
        {
            "cob_id": Parameter("the identifier it has", 0x57F, int, low=1, high=STANDARD_IDS[-1]),
            **TPDO,
            **AIM,
        },
        lambda place, number, cob_id, **aim: Filtering(
            place, tpdo(place, number), renamed(cob_id), **aim
        ),
    ),
    "pdo_jitter": FaultType(
        "A TPDO comes late, each time by another time; none overtakes another.",
        "Cycles that are too short and too long: no alarm below the limit, one above.",
        {"seconds": Parameter("at most by how much, in s", 0.01, low=0), **TPDO, **AIM},
        lambda place, number, seconds, **aim: Filtering(
            place,
            tpdo(place, number),
            jittered(place, seconds, aim["seed"]),
            **aim,
        ),
    ),
}

TELLING = frozenset({State.PRE_OPERATIONAL, State.OPERATIONAL})


class Storm(Disturbance):
    """The same emergency again and again."""

    def __init__(  # noqa: PLR0913, PLR0917 - the parameters of the fault
        self, place: Place, seconds: float, times: int, code: int, register: int, detail: int
    ) -> None:
        super().__init__(place)
        self._seconds = seconds
        self._times = times
        self._told = 0
        content = detail.to_bytes(FIELD_LENGTH, "little")
        self._data = emcy_data(Emcy(code, register, content), register)

    @property
    def over(self) -> bool:
        """All of them have been told."""
        return 0 < self._times <= self._told

    def start(self) -> None:
        """The first one comes at once."""
        self._tell()

    def _tell(self) -> None:
        slave = self.node.slave
        cob_id = None if slave is None else emcy_id(slave)
        if slave is not None and cob_id is not None and self.node.state in TELLING:
            slave.send(Frame(cob_id, self._data))
            self._told += 1
        if not self.over:
            self.clock.after(self._seconds, self._tell)


def is_emcy(node: Node, frame: Frame) -> bool:
    """Whether a frame is an emergency of a node."""
    slave = node.slave
    return slave is not None and not frame.remote and frame.can_id == emcy_id(slave)


def _of_emcy(place: Place, effect: Effect, **aim: Any) -> Filtering:
    if not place.node.device.has_emergencies:
        raise UserError("there is no emergency that could go wrong: this device has none")
    return Filtering(place, is_emcy, effect, **aim)


EMCY: Mapping[str, FaultType] = {
    "emcy_storm": FaultType(
        "An emergency is told again and again, in whatever state the device is.",
        "More messages than it can work off: none of another node may be lost, nor its own cycle.",
        {
            "seconds": Parameter("from one to the next, in s", 0.001, low=1e-5),
            "times": Parameter("how many; 0: no end", 0, int, low=0),
            "code": Parameter("emergency error code", 0x1000, int, low=0, high=0xFFFF),
            "register": Parameter("error register", 0x01, int, low=0, high=0xFF),
            "detail": Parameter("the manufacturer's field, as one number", 0, int, 0, 2**40 - 1),
        },
        Storm,
    ),
    "emcy_lost": FaultType(
        "An emergency is not told.",
        "An error it learns of from the error register or from process data only.",
        AIM,
        lambda place, **aim: _of_emcy(place, lost, **aim),
    ),
    "emcy_doubled": FaultType(
        "An emergency is told twice.",
        "One error, told twice: to be counted and shown once.",
        AIM,
        lambda place, **aim: _of_emcy(place, doubled, **aim),
    ),
}

SECONDS = Parameter("by how much, in s", 1.0, low=0)
PERIOD = Parameter("from one to the next, in s", 1.0, low=1e-6)


def is_heartbeat(node: Node, frame: Frame) -> bool:
    """Whether a frame is a heartbeat of a node; the boot-up message is none."""
    return _is_error_control(node, frame) and frame.data != BOOT_UP


def is_boot_up(node: Node, frame: Frame) -> bool:
    """Whether a frame is the boot-up message of a node."""
    return _is_error_control(node, frame) and frame.data == BOOT_UP


def _is_error_control(node: Node, frame: Frame) -> bool:
    return frame.can_id == identifiers.heartbeat(node.node_id) and not frame.remote


ERROR_CONTROL: Mapping[str, FaultType] = {
    "heartbeat_stopped": FaultType(
        "Heartbeats do not come; the node goes on.",
        "A heartbeat event: the node counts as lost, although it answers.",
        AIM,
        lambda place, **aim: Filtering(place, is_heartbeat, lost, **aim),
    ),
    "heartbeat_late": FaultType(
        "Heartbeats come late.",
        "One gap of a period more; whether it is a loss is for the consumer time to say.",
        {"seconds": SECONDS, **AIM},
        lambda place, seconds, **aim: Filtering(place, is_heartbeat, late(seconds), **aim),
    ),
    "heartbeat_jitter": FaultType(
        "Heartbeats come late, each by another time; none overtakes another.",
        "Irregular heartbeats: no event as long as the consumer time is kept.",
        {"seconds": Parameter("at most by how much, in s", 0.1, low=0), **AIM},
        lambda place, seconds, **aim: Filtering(
            place,
            is_heartbeat,
            jittered(place, seconds, aim["seed"]),
            **aim,
        ),
    ),
    "heartbeat_wrong_state": FaultType(
        "Heartbeats show another state than the node is in.",
        "A state it did not command: an alarm, and a new NMT command.",
        {
            "state": Parameter(
                "0x04 stopped, 0x05 operational, 0x7f pre-operational, or any byte",
                0x04,
                int,
                low=0,
                high=0xFF,
            ),
            **AIM,
        },
        lambda place, state, **aim: Filtering(
            place, is_heartbeat, altered(lambda _: bytes([state])), **aim
        ),
    ),
    "boot_up_lost": FaultType(
        "The boot-up message does not come.",
        "A node that is there without having said so: to be found by reading 0x1000.",
        AIM,
        lambda place, **aim: Filtering(place, is_boot_up, lost, **aim),
    ),
    "boot_up_repeated": FaultType(
        "The boot-up message comes several times, although the node boots once.",
        "A node that seems to boot again: to be configured again, and no endless loop.",
        {
            "repeats": Parameter("how many times more", 1, int, low=1, high=1000),
            "seconds": PERIOD,
            **AIM,
        },
        lambda place, repeats, seconds, **aim: Filtering(
            place, is_boot_up, repeated(repeats, seconds), **aim
        ),
    ),
}
