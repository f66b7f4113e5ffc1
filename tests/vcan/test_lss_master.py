import sys

import pytest

from tests.vcan.bus import Process

pytestmark = pytest.mark.vcan

IDENTITY = (0x1C4, 0, 9, 1)


@pytest.fixture
def lss(stack, candump, network):
    """canopen's LssMaster, and one slave that it has selected by its identity."""
    slave = Process(sys.executable, "-m", "tests.vcan.lss_slave", stderr=None)
    stack.enter_context(slave)
    candump.until("705#00")
    assert network.lss.send_switch_state_selective(*IDENTITY)
    return network.lss


def test_lss_master_reads_node_id_and_identity(lss):
    assert lss.inquire_node_id() == 5
    assert tuple(lss.inquire_lss_address(0x5A + part) for part in range(4)) == IDENTITY


def test_lss_master_gives_a_node_id_that_holds_after_a_reset(lss, candump, network):
    lss.configure_node_id(42)
    lss.store_configuration()
    lss.send_switch_state_global(lss.WAITING_STATE)
    network.nmt.send_command(0x82)
    candump.until("72A#00")
    assert network.add_node(42).sdo.upload(0x1018, 1) == (0x1C4).to_bytes(4, "little")
