import pytest

from .bus import RESET_COMMUNICATION, RESET_NODE, START, run, state_of_output

READ_DEVICE_TYPE = "605#4000100000000000"


@pytest.mark.spec("T-011", "A-21", "A-58")
def test_reset_communication_restores_the_communication_and_nothing_else(topcon):
    topcon.sdo["COB-ID SYNC message"].raw = 0x85
    topcon.sdo["Producer Heartbeat Time"].raw = 5000
    topcon.sdo["Transmit PDO 1 Communication Parameter"]["Transmission type"].raw = 1
    topcon.sdo["Transmit PDO 2 Communication Parameter"]["COB-ID TPDO2"].raw = 0x285
    topcon.sdo["Receive PDO 1 Communication Parameter"]["transmission type"].raw = 0
    run(topcon, voltage=2000)
    topcon.sdo["Overvoltage level"].raw = 3000
    topcon.sdo["Register Read/Write"]["Address"].raw = 0x42
    topcon.run(1.0)
    topcon.send(RESET_COMMUNICATION)
    assert topcon.sdo["COB-ID SYNC message"].raw == 0x80
    assert topcon.sdo["Producer Heartbeat Time"].raw == 0
    assert topcon.sdo["Transmit PDO 1 Communication Parameter"]["Transmission type"].raw == 253
    assert topcon.sdo["Transmit PDO 2 Communication Parameter"]["COB-ID TPDO2"].raw == 0x80000285
    assert topcon.sdo["Receive PDO 1 Communication Parameter"]["transmission type"].raw == 254
    assert topcon.sdo["Voltage reference"].raw == 2000
    assert topcon.sdo["Overvoltage level"].raw == 3000
    assert topcon.sdo["Register Read/Write"]["Address"].raw == 0x42
    assert topcon.sdo["Run command"].raw == 1
    assert state_of_output(topcon) == 0x0003


@pytest.mark.spec("T-012", "A-58")
def test_reset_node_also_restores_the_manufacturer_objects_and_stops(topcon):
    run(topcon, 2000, 2000, 2000, 2000)
    topcon.sdo["Overvoltage level"].raw = 3000
    topcon.sdo["Overcurrent level"].raw = 3000
    topcon.sdo["Register Read/Write"]["Address"].raw = 0x42
    topcon.sdo["Producer Heartbeat Time"].raw = 5000
    topcon.run(1.0)
    assert topcon.send(RESET_NODE) == ["705#00"]
    read = [topcon.sdo[index].raw for index in range(0x2010, 0x2015)]
    assert read == [0, 0, 4000, 0, 0]
    assert [topcon.sdo["Overvoltage level"].raw, topcon.sdo["Overcurrent level"].raw] == [4400] * 2
    assert topcon.sdo["Register Read/Write"]["Address"].raw == 0
    assert topcon.sdo["Producer Heartbeat Time"].raw == 0
    assert state_of_output(topcon) == 0


@pytest.mark.spec("A-76")
def test_without_mains_the_whole_node_is_gone_and_comes_back_as_new(topcon):
    topcon.sdo["Producer Heartbeat Time"].raw = 100
    topcon.send(START)
    run(topcon, voltage=2000)
    topcon.run(1.0)
    topcon.power_off()
    assert topcon.device.report["mode"] == "OFF"
    assert [topcon.send(frame) for frame in (READ_DEVICE_TYPE, "185#R", START, RESET_NODE)] == 4 * [
        []
    ]
    assert topcon.run(10) == []
    before = len(topcon.sent)
    topcon.power_on()
    assert topcon.sent[before:] == ["705#00"]  # no EMCY
    assert topcon.sdo["Pre-defined Error Field"][0].raw == 0
    assert topcon.sdo["Run command"].raw == 0
    assert state_of_output(topcon) == 0
    assert topcon.sdo["Actual voltage"].raw == 0
