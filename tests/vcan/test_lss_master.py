import pytest

pytestmark = pytest.mark.vcan


@pytest.fixture
def identity(run, candump, network):
    """That of a twin that canopen's LssMaster has selected by it."""
    run("charger", 5)
    candump.until("705#00")
    sdo = network.add_node(5).sdo
    identity = [int.from_bytes(sdo.upload(0x1018, part), "little") for part in range(1, 5)]
    assert network.lss.send_switch_state_selective(*identity)
    return identity


def test_lss_master_reads_node_id_and_identity(identity, network):
    assert network.lss.inquire_node_id() == 5
    assert [network.lss.inquire_lss_address(0x5A + part) for part in range(4)] == identity


def test_lss_master_gives_a_node_id_that_holds_after_a_reset(identity, candump, network):
    network.lss.configure_node_id(42)
    network.lss.store_configuration()
    network.lss.send_switch_state_global(network.lss.WAITING_STATE)
    network.nmt.send_command(0x82)
    candump.until("72A#00")
    vendor = network.add_node(42).sdo.upload(0x1018, 1)
    assert int.from_bytes(vendor, "little") == identity[0]
