"""Protocol level, EMCY: emergencies come too often, or not at all."""

from collections.abc import Mapping

from canopen_twins.bus.frame import Frame
from canopen_twins.device.faults import Parameter
from canopen_twins.device.node import Node
from canopen_twins.faults.disturbance import (
    AIM,
    Disturbance,
    Filtering,
    Kind,
    Place,
    Turn,
    doubled,
    lost,
)
from canopen_twins.slave.emcy import FIELD_LENGTH, Emcy, emcy_data, emcy_id
from canopen_twins.slave.service import State

TELLING = frozenset({State.PRE_OPERATIONAL, State.OPERATIONAL})


class Storm(Disturbance):
    """The same emergency again and again."""

    def __init__(  # noqa: PLR0913, PLR0917 - the parameters of the fault
        self, place: Place, seconds: float, times: int, code: int, register: int, detail: int
    ) -> None:
        super().__init__(place.node)
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
        if cob_id is not None and self.node.state in TELLING:
            self.node.wire.put(Frame(cob_id, self._data))
            self._told += 1
        if not self.over:
            self.clock.after(self._seconds, self._tell)


def is_emcy(node: Node, frame: Frame) -> bool:
    """Whether a frame is an emergency of a node."""
    slave = node.slave
    return slave is not None and not frame.remote and frame.can_id == emcy_id(slave)


EMCY: Mapping[str, Kind] = {
    "emcy_storm": Kind(
        "An emergency is told again and again, in whatever state the device is.",
        "More messages than it can work off: none of another node may be lost, nor its own cycle.",
        {
            "seconds": Parameter("from one to the next, in s", 0.001, low=1e-6),
            "times": Parameter("how many; 0: no end", 0, int, low=0),
            "code": Parameter("emergency error code", 0x1000, int, low=0, high=0xFFFF),
            "register": Parameter("error register", 0x01, int, low=0, high=0xFF),
            "detail": Parameter("the manufacturer's field, as one number", 0, int, 0, 2**40 - 1),
        },
        Storm,
    ),
    "emcy_lost": Kind(
        "An emergency is not told.",
        "An error it learns of from the error register or from process data only.",
        AIM,
        lambda place, **turn: Filtering(place.node, is_emcy, lost, Turn(**turn)),
    ),
    "emcy_doubled": Kind(
        "An emergency is told twice.",
        "One error, told twice: to be counted and shown once.",
        AIM,
        lambda place, **turn: Filtering(place.node, is_emcy, doubled, Turn(**turn)),
    ),
}
