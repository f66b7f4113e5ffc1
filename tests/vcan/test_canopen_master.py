from queue import SimpleQueue

import pytest
from canopen.nmt import NMT_COMMANDS

from canopen_twins.files.shipped import od_file

pytestmark = pytest.mark.vcan


@pytest.fixture
def topcon(run, candump, network):
    """A twin as canopen's RemoteNode sees it."""
    run("topcon", 5)
    candump.until("705#00")
    with od_file("topcon.eds") as eds:
        return network.add_node(5, str(eds))


def test_the_identity_is_that_of_the_eds(topcon):
    for subindex in (1, 2, 3):
        entry = topcon.object_dictionary[0x1018][subindex]
        assert topcon.sdo[0x1018][subindex].raw == entry.default
    assert topcon.sdo[0x1008].raw == topcon.object_dictionary[0x1008].default
    assert topcon.sdo[0x100A].raw == "V4.11.45"


def test_the_output_follows_and_is_measured(topcon):
    topcon.sdo["Current reference"].raw = 4000
    topcon.sdo["Voltage reference"].raw = 2000
    topcon.sdo["Run command"].raw = 1
    while topcon.sdo["Actual voltage"].raw < 1990:
        pass
    assert topcon.sdo["State of output"].raw & 1


def test_heartbeat_and_nmt_states(topcon, candump):
    topcon.sdo[0x1017].raw = 20
    topcon.nmt.wait_for_heartbeat(timeout=10.0)
    for state in ("OPERATIONAL", "STOPPED", "PRE-OPERATIONAL"):
        topcon.nmt.send_command(NMT_COMMANDS[state])
        while topcon.nmt.state != state:
            topcon.nmt.wait_for_heartbeat(timeout=10.0)
    topcon.nmt.state = "RESET"
    candump.until("705#00")
    while topcon.nmt.state != "PRE-OPERATIONAL":
        topcon.nmt.wait_for_heartbeat(timeout=10.0)


def test_pdos_go_both_ways(topcon):
    topcon.nmt.state = "OPERATIONAL"
    topcon.rpdo.read()
    topcon.rpdo[1][0].raw = 1234
    topcon.rpdo[1].transmit()
    assert topcon.sdo["Voltage reference"].raw == 1234
    topcon.tpdo.read()
    received = (
        SimpleQueue()
    )  # before the request: the answer is faster than a wait that comes after
    topcon.tpdo[1].add_callback(received.put)
    topcon.tpdo[1].remote_request()
    # not `wait_for_reception`: the answer is there before its wait begins
    assert [variable.raw for variable in received.get(timeout=10.0)] == [0, 0, 0, 0]


def test_an_overvoltage_is_told(topcon):
    topcon.nmt.state = "OPERATIONAL"
    topcon.sdo["Overvoltage level"].raw = 2000
    topcon.sdo["Current reference"].raw = 4000
    topcon.sdo["Voltage reference"].raw = 1900
    topcon.sdo["Run command"].raw = 1
    topcon.sdo["Voltage reference"].raw = 3000
    emcy = topcon.emcy.wait(timeout=10.0)
    assert (emcy.code, emcy.register) == (0x3300, 0x05)
