"""A device without physics: one of everything the services know, and a log of what it is told."""

from dataclasses import dataclass
from math import inf
from pathlib import Path

from canopen_twins.device.device import Device
from canopen_twins.device.faults import Fault, Parameter
from canopen_twins.device.settings import NodeSettings, setting
from canopen_twins.slave.emcy import Emcy
from canopen_twins.slave.object import Abort, Object, Rejected
from canopen_twins.slave.profile import Profile

LEVEL, EVEN, REFUSING, FAULTY, BYTES, TWICE = ((0x2100 + n, 0) for n in range(6))


@dataclass(frozen=True)
class Settings(NodeSettings):
    level: int = setting(0, "what the level is set to", live=True)


class Probe(Device):
    """`told` is the log; `rest`, `online`, `cycle` and `profile` are a test's to choose."""

    eds = str(Path(__file__).with_name("probe.eds"))
    title = "Probe of the engine"
    settings = Settings()
    stored = ((0x1017, 0), (0x2001, 0), (0x2003, 0), LEVEL)
    rest = inf
    online = True
    emergencies = ()
    nmt_state = None

    def __init__(self, node_id=5, **given):
        profile = {name: given.pop(name) for name in [*given] if hasattr(Profile, name)}
        super().__init__(node_id=node_id, **given)
        self.profile = Profile(**profile)
        self.told = []
        self.frames = 0
        self.level = 0
        self.content = b""
        self.falls_over = False

    @property
    def objects(self):
        return {
            LEVEL: Object(read=lambda: self.level, write=self._set),
            EVEN: Object(adjust=lambda value: value & ~1),
            REFUSING: Object(read=self._refuse, write=self._refuse),
            FAULTY: Object(read=self._fall_over, write=self._fall_over),
            BYTES: Object(read=lambda: self.content),
            TWICE: Object(read=lambda: 2 * self.level),
        }

    @property
    def faults(self):
        code = Parameter("emergency error code, 0x0001..0xffff", kind=int)
        register = Parameter("bits of the error register", 0x01, int)
        return {
            "error": Fault(
                "An error until it is cleared.",
                lambda code, register: self._raise(Emcy(code, register, b"field")),
                lambda code, register: self._take_back(code),
                {"code": code, "register": register},
            ),
            "level": Fault(
                "The level jumps.",
                self._set,
                parameters={"value": Parameter("what it jumps to", kind=int)},
            ),
        }

    def power_on(self):
        self.level = 0
        self.emergencies = ()
        self.told.append("power on")

    def power_off(self):
        self.told.append("power off")

    def reset_node(self):
        self.level = 0
        self.told.append("reset node")

    def reset_communication(self):
        self.told.append("reset communication")

    def save(self):
        self.told.append("save")

    def restore(self):
        self.told.append("restore")

    def on_state(self, state):
        self.told.append(str(state))

    def on_frame(self):
        self.frames += 1

    def on_heartbeat(self, node_id, alive):
        self.told.append(f"node {node_id} is {'back' if alive else 'silent'}")
        self.emergencies = () if alive else (Emcy(0x8130, 0x11),)

    def on_rpdo_refused(self, number, refusal):
        self.told.append(f"RPDO {number}: {refusal} ({refusal.code:08X}h)")

    def apply(self):
        self.level = self.settings.level

    def step(self, dt):
        if self.falls_over:
            raise KeyError("a bug in the model")
        self.told.append(dt)

    @property
    def steps(self):
        """The times, in seconds, by which the model was stepped."""
        return [entry for entry in self.told if isinstance(entry, float)]

    def _set(self, value):
        self.level = value

    def _raise(self, emcy):
        self.emergencies = (*self.emergencies, emcy)

    def _take_back(self, code):
        self.emergencies = tuple(emcy for emcy in self.emergencies if emcy.code != code)

    def _refuse(self, value=None):
        raise Rejected("always", Abort.LOCAL_CONTROL)

    def _fall_over(self, value=None):
        raise KeyError("a bug in an object")


def configure(bench, *requests):
    """Send SDO downloads; each must be accepted."""
    for request in requests:
        (answer,) = bench.send(request)
        assert answer[4:12] == "60" + request[6:12], (request, answer)
