"""What a master of node 5 sends, in the notation of cansend."""

from contextlib import contextmanager

import pytest
from canopen import SdoAbortedError

START, STOP, ENTER_PREOP = "000#0105", "000#0205", "000#8005"
RESET_NODE, RESET_COMMUNICATION = "000#8105", "000#8205"
SYNC = "080#"


@contextmanager
def refused(code):
    """The SDO access inside is aborted with this code."""
    with pytest.raises(SdoAbortedError) as abort:
        yield
    assert hex(abort.value.code) == hex(code)


def run(bench, voltage=4000, current=4000, power=4000, resistance=0):
    """Set values in parts, then RUN."""
    bench.sdo["Voltage reference"].raw = voltage
    bench.sdo["Current reference"].raw = current
    bench.sdo["Power reference"].raw = power
    bench.sdo["Internal resistance reference"].raw = resistance
    bench.sdo["Run command"].raw = 1


def state_of_output(bench):
    """0x2023 as it is read over the bus."""
    return bench.sdo["State of output"].raw
