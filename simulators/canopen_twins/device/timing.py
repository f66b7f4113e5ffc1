"""Times of a real device: the presets, and what the settings of a node make of them.

The figures are assumed, for no device in particular (docs/reference/timing.md).
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields

from canopen_twins.device.settings import TimingSettings


@dataclass(frozen=True)
class Timing:
    """What is in force, in seconds; nothing of it takes time when all are 0."""

    boot_time: float = 0.0
    answer_time: float = 0.0
    answer_jitter: float = 0.0
    store_time: float = 0.0
    measure_time: float = 0.0
    noise: float = 0.0
    """Digits up and down."""


IDEAL = Timing()
PRESETS: Mapping[str, Timing] = {
    "ideal": IDEAL,
    "typical": Timing(0.3, 0.002, 0.001, 0.1, 0.02, 1.0),
    "worst": Timing(3.0, 0.05, 0.05, 0.8, 0.2, 5.0),
}


def timing_of(settings: object, presets: Mapping[str, Timing] = PRESETS) -> Timing:
    """What settings say, and their preset where they say nothing.

    Settings that know no times are ideal.
    """
    if not isinstance(settings, TimingSettings):
        return IDEAL
    preset = presets[settings.timing]
    said = {entry.name: getattr(settings, entry.name) for entry in fields(Timing)}
    return Timing(
        **{
            name: getattr(preset, name) if value is None else value for name, value in said.items()
        }
    )
