from collections.abc import Callable

import pytest

from canopen_twins import Bench

START, SYNC = "000#0105", "080#"
READ_VOLTAGE = "605#4020200000000000"
READ_VERSION = "605#400A100000000000"


@pytest.fixture
def topcon() -> Bench:
    """Node 5 in Operational, at 125 kbit/s: heartbeat every 100 ms, TPDO 1 with every SYNC."""
    bench = Bench("topcon", node_id=5, br=4)
    bench.sdo["Producer Heartbeat Time"].raw = 100
    bench.sdo[0x1800][2].raw = 1
    bench.send(START)
    return bench


@pytest.fixture
def active(topcon) -> Callable[[], list[str]]:
    """The names of the faults that are active."""
    return lambda: list(topcon.twin.node.faults.active)
