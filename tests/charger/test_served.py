import canopen
import pytest
from canopen.lss import LssError

pytestmark = pytest.mark.usefixtures("quick_to_disconnect")


@pytest.fixture
def network(canopen_device):
    """A canopen master on the bus of a charger that is served in real time."""
    charger = canopen_device("charger", serial=4711)
    network = canopen.Network()
    network.connect(**charger.bus)
    yield network
    network.disconnect()


@pytest.mark.spec("C-050", "C-052", "C-055", "C-056", "C-058")
def test_canopens_lss_master_moves_it_on_a_bus_in_real_time(network):
    moved = canopen.RemoteNode(42, canopen.ObjectDictionary())
    network.add_node(moved)
    lss = network.lss
    with pytest.raises(LssError):
        lss.send_switch_state_selective(0x24E, 1, 0x00010000, 4712)
    assert lss.send_switch_state_selective(0x24E, 1, 0x00010000, 4711)
    assert lss.inquire_node_id() == 99
    lss.configure_node_id(42)
    lss.configure_bit_timing(2)
    lss.store_configuration()
    lss.send_switch_state_global(lss.WAITING_STATE)
    network.nmt.send_command(0x82)
    moved.nmt.wait_for_bootup(timeout=30)
    assert moved.sdo.upload(0x2002, 0x06) == b"\x2a"
    assert moved.sdo.upload(0x2002, 0x07) == b"\x02"


def test_a_master_releases_it_on_a_bus_in_real_time(network):
    charger = network.add_node(99, canopen.ObjectDictionary())
    charger.sdo.download(0x2002, 0x02, b"\x08")
    charger.sdo.download(0x2002, 0x11, b"\x64\x00")
    charger.nmt.state = "OPERATIONAL"
    network.send_message(0x263, [0x0F])
    assert charger.sdo.upload(0x6000, 0x01) == b"\x29"
    with pytest.raises(canopen.SdoAbortedError):
        charger.sdo.download(0x6200, 0x01, b"\x01")
    network.send_message(0x263, [0x00])
    assert charger.sdo.upload(0x6000, 0x01) == b"\x00"
