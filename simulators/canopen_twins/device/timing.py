"""Times of a real device: the presets, and what the settings of a node make of them.

The figures are assumed, for no device in particular (docs/reference/timing.md).
"""

from collections.abc import Callable, Mapping
from random import Random
from typing import NamedTuple

from canopen_twins.bus import sdo
from canopen_twins.bus.sdo import Ccs
from canopen_twins.device.settings import TimingSettings
from canopen_twins.slave.request_buffer import RequestBuffer
from canopen_twins.slave.slave import Slave
from canopen_twins.slave.store import LOAD, SAVE


class Timing(NamedTuple):
    """What is in force, in seconds; nothing takes time when all are 0."""

    boot_time: float = 0.0
    answer_time: float = 0.0
    answer_jitter: float = 0.0
    store_time: float = 0.0
    measure_time: float = 0.0
    noise: float = 0.0
    """Digits up and down."""
    requests_wait: bool = False
    store_refuses: bool = False
    seed: int = 0

    @property
    def measures(self) -> bool:
        """Whether measured values are others than those of the model."""
        return bool(self.measure_time or self.noise)


IDEAL = Timing()
PRESETS: Mapping[str, Timing] = {
    "ideal": IDEAL,
    "typical": Timing(
        boot_time=0.3,
        answer_time=0.002,
        answer_jitter=0.001,
        store_time=0.1,
        measure_time=0.02,
        noise=1.0,
    ),
    "worst": Timing(
        boot_time=3.0,
        answer_time=0.05,
        answer_jitter=0.05,
        store_time=0.8,
        measure_time=0.2,
        noise=5.0,
    ),
}
NUMBERS = ("boot_time", "answer_time", "answer_jitter", "store_time", "measure_time", "noise")


def timing_of(settings: object, presets: Mapping[str, Timing] = PRESETS) -> Timing:
    """What settings say, and their preset where they say nothing.

    Settings that know no times are ideal.
    """
    if not isinstance(settings, TimingSettings):
        return IDEAL
    said = {name: getattr(settings, name) for name in NUMBERS}
    return presets[settings.timing]._replace(
        requests_wait=settings.busy_request == "waits",
        store_refuses=settings.store_busy == "refuses",
        seed=settings.seed,
        **{name: value for name, value in said.items() if value is not None},
    )


def request_buffer(
    slave: Slave, timing: Timing, on_lost: Callable[[], None]
) -> RequestBuffer | None:
    """Where requests to the SDO server of a slave wait; none if they are answered at once."""
    store_time = 0.0 if timing.store_refuses else timing.store_time
    if not (timing.answer_time or timing.answer_jitter or store_time):
        return None
    chance = Random(f"{timing.seed} {slave.node_id}")

    def delay(data: bytes) -> float:
        jitter = chance.uniform(0.0, timing.answer_jitter)
        return timing.answer_time + jitter + store_time * _stores(slave, data)

    events = slave.wire.events
    return RequestBuffer(slave.clock, events, delay, on_lost, waits=timing.requests_wait)


def _stores(slave: Slave, data: bytes) -> bool:
    """Whether a request is a command to store or restore, with the signature that is wanted."""
    signature = {0x1010: SAVE, 0x1011: LOAD}.get(sdo.address(data)[0])
    if signature is None or sdo.specifier(data) != Ccs.DOWNLOAD or not sdo.is_expedited(data):
        return False
    return not slave.profile.store_signature or sdo.value(data) == signature.to_bytes(4, "little")
