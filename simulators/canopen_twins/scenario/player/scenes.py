"""What is shown of the moment at which something was not as it should be."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence

from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Record
from canopen_twins.device.node import Node
from canopen_twins.diagnosis.report import SHOWN, device_report, last_frames
from canopen_twins.scenario.scenario import Step

AFTERWARDS = 5  # frames


class Scene:
    """The last frames, how the nodes are at this moment, and the first frames after it.

    `reports` say how the nodes are, and why they answered as they did.
    """

    def __init__(
        self, before: Sequence[Record], nodes: Sequence[Node], time: float, reports: Sequence[str]
    ) -> None:
        self._nodes = nodes
        self._before = last_frames(before, nodes)
        self._state = "\n".join(reports)
        self._mark = f"{time:12.6f}  ---- here"
        self._after: list[Record] = []

    @property
    def complete(self) -> bool:
        """Whether as much has come after it as is shown."""
        return len(self._after) == AFTERWARDS

    def hear(self, record: Record) -> None:
        """Take a frame that has come after it."""
        self._after.append(record)

    def __str__(self) -> str:
        after = [self._mark, last_frames(self._after, self._nodes)] if self._after else []
        return "\n".join([self._before, *after, self._state])


class Scenes:
    """Keeps the last frames, and the scenes that are waiting for the next ones.

    `time` gives the seconds of the scenario for a microsecond of the clock.
    """

    def __init__(self, nodes: Mapping[str, Node], time: Callable[[int], float]) -> None:
        self._nodes = nodes
        self._time = time
        self._recent: deque[tuple[int, Frame, str]] = deque(maxlen=SHOWN)
        self._open: list[Scene] = []

    def hear(self, tick: int, frame: Frame, sender: str) -> None:
        """Take a frame."""
        self._recent.append((tick, frame, sender))
        if self._open:
            record = Record(self._time(tick), frame, sender)
            for scene in self._open:
                scene.hear(record)
            self._open = [scene for scene in self._open if not scene.complete]

    def begin(self, time: float, step: Step) -> Scene:
        """The scene of this moment, which takes in what comes after it."""
        scene = self.look(time, step)
        self._open.append(scene)
        return scene

    def look(self, time: float, step: Step) -> Scene:
        """The scene of this moment, as it is; what a step wants concerns its node."""
        records = [Record(self._time(tick), frame, sender) for tick, frame, sender in self._recent]
        wanted = str(step.action), step.action.about
        reports = [
            device_report(node, records, -self._time(0), *(wanted if name == step.node else ()))
            for name, node in self._nodes.items()
        ]
        return Scene(records, tuple(self._nodes.values()), time, reports)
