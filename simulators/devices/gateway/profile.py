"""What the communication of the gateway leaves of CiA 301: Table 3 to the letter, 16 ms steps."""

from simulators.devices.gateway.model.timing import MILLISECOND, MOST_HEARTBEAT_CYCLES, cycles
from simulators.profile import Profile

MICROSECOND = 1e-6  # s
MAIN_CYCLE = 16 * MILLISECOND  # us, of the gateway (7.2.3)


def heartbeat_period(milliseconds: int) -> float:
    """Seconds between two heartbeats: whole main cycles (7.2.3)."""
    return cycles(milliseconds, MAIN_CYCLE, MOST_HEARTBEAT_CYCLES) * MAIN_CYCLE * MICROSECOND


PROFILE = Profile(
    segmented=False,
    literal_commands=True,
    length_before_access=True,
    heartbeat_period=heartbeat_period,
)
