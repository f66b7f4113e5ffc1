import pytest
from canopen.lss import LssError
from charger_bus import (
    CONFIGURE,
    INQUIRE_NODE_ID,
    RESET_COMMUNICATION,
    RESET_NODE,
    SAVE,
    SAVED,
    WAIT,
    put,
    refused,
    restart,
    value,
)

from canopen_twins import Bench

STORE = "7E5#1700000000000000"
BOOTED_AS_42 = ["72A#00"]


def configure(bench, node_id=42, bit_timing=2):
    bench.send(CONFIGURE)
    assert bench.send(f"7E5#11{node_id:02X}000000000000") == ["7E4#1100000000000000"]
    assert bench.send(f"7E5#1300{bit_timing:02X}0000000000") == ["7E4#1300000000000000"]


@pytest.mark.spec("C-118", "C-060")
def test_as_delivered_it_is_node_99_at_125_kbit(bench):
    assert (value(bench, 0x06), value(bench, 0x07)) == (99, 4)
    assert bench.device.report["bit rate [kbit/s]"] == 125


@pytest.mark.spec("C-118", "C-119", "A-34")
@pytest.mark.parametrize("how", [RESET_NODE, RESET_COMMUNICATION, "power"])
def test_a_written_place_acts_after_saving_and_a_restart(bench, how):
    put(bench, {0x06: 42, 0x07: 2})
    assert bench.send(SAVE) == SAVED
    assert (bench.run(1.0), bench.device.report["bit rate [kbit/s]"]) == (["763#7F"], 125)
    restart(bench, how)
    assert bench.sent[-1:] == BOOTED_AS_42
    assert bench.device.report["bit rate [kbit/s]"] == 500


@pytest.mark.spec("C-118", "A-34")
@pytest.mark.parametrize("how", [RESET_NODE, RESET_COMMUNICATION, "power"])
def test_a_written_place_that_was_not_saved_never_acts(bench, how):
    put(bench, {0x06: 42, 0x07: 2})
    assert (value(bench, 0x06), value(bench, 0x07)) == (42, 2)
    restart(bench, how)
    assert bench.sent[-1] == "763#00"
    forgotten = how != RESET_COMMUNICATION
    assert value(bench, 0x06) == (99 if forgotten else 42)


@pytest.mark.spec("C-056", "A-34")
def test_what_lss_configures_acts_after_a_reset_of_the_communication(bench):
    configure(bench)
    assert bench.send(INQUIRE_NODE_ID) == ["7E4#5E63000000000000"]
    assert value(bench, 0x06) == 99
    assert bench.send(RESET_COMMUNICATION) == BOOTED_AS_42
    assert bench.device.report["bit rate [kbit/s]"] == 500
    assert bench.send("000#812A") == ["763#00"]  # it was never stored


@pytest.mark.spec("C-055", "C-056", "C-060", "A-34")
@pytest.mark.parametrize("how", [RESET_NODE, RESET_COMMUNICATION, "power"])
def test_what_lss_stores_is_the_parameter(bench, how):
    configure(bench)
    assert bench.send(STORE) == ["7E4#1700000000000000"]
    assert (value(bench, 0x06), value(bench, 0x07)) == (42, 2)
    restart(bench, how)
    assert bench.sent[-1:] == BOOTED_AS_42
    restart(bench, "power")
    assert bench.sent[-1:] == BOOTED_AS_42


@pytest.mark.spec("C-060", "A-34")
def test_saving_lets_the_parameter_wait_in_place_of_what_lss_configured(bench):
    configure(bench, node_id=55)
    put(bench, {0x06: 42})
    bench.send(SAVE)
    assert bench.send(RESET_COMMUNICATION) == BOOTED_AS_42


@pytest.mark.spec("C-055", "A-34")
def test_storing_by_lss_keeps_no_other_parameter(bench):
    put(bench, {0x08: 5000})
    configure(bench)
    bench.send(STORE)
    assert bench.send(RESET_NODE) == BOOTED_AS_42
    assert value(bench, 0x08) == 1500


@pytest.mark.spec("C-055")
def test_a_worn_memory_is_told_the_lss_master(bench):
    bench.inject("memory_failure")
    configure(bench)
    assert bench.send(STORE) == ["7E4#1702000000000000"]
    assert value(bench, 0x06) == 99


@pytest.mark.spec("C-053", "C-118", "A-39")
@pytest.mark.parametrize(("node_id", "code"), [(0, 1), (1, 0), (127, 0), (128, 1), (255, 1)])
def test_which_node_ids_there_are(bench, node_id, code):
    bench.send(CONFIGURE)
    assert bench.send(f"7E5#11{node_id:02X}000000000000") == [f"7E4#11{code:02X}000000000000"]
    if code:
        with refused(0x06090031 if node_id else 0x06090032):
            put(bench, {0x06: node_id})
    else:
        put(bench, {0x06: node_id})


RATES = {0: 1000, 1: 800, 2: 500, 3: 250, 4: 125, 6: 50, 7: 25, 8: 10}


@pytest.mark.spec("C-054", "C-119", "A-15")
@pytest.mark.parametrize("index", range(10))
def test_which_bit_timings_there_are(bench, index):
    bench.send(CONFIGURE)
    code = 0 if index in RATES else 1
    assert bench.send(f"7E5#1300{index:02X}0000000000") == [f"7E4#13{code:02X}000000000000"]
    assert bench.send(f"7E5#1301{index:02X}0000000000") == ["7E4#1301000000000000"]
    if index in RATES:
        put(bench, {0x07: index})
        bench.send(SAVE)
        bench.send(RESET_NODE)
        assert bench.device.report["bit rate [kbit/s]"] == RATES[index]
    else:
        with refused(0x06090030 if index == 5 else 0x06090031):
            put(bench, {0x07: index})


@pytest.mark.spec("C-057", "A-39")
def test_a_bit_timing_is_activated_without_a_reset(quiet):
    configure(quiet)
    assert quiet.send("7E5#15F401" + "0000000000") == []
    quiet.run(0.49)
    assert quiet.device.report["bit rate [kbit/s]"] == 125
    quiet.run(0.02)
    assert quiet.device.report["bit rate [kbit/s]"] == 500
    assert quiet.send(INQUIRE_NODE_ID) == []
    quiet.run(0.5)
    assert quiet.send(INQUIRE_NODE_ID) == ["7E4#5E63000000000000"]


@pytest.mark.spec("C-050", "C-052", "C-055", "C-058", "C-059")
def test_canopens_master_moves_it():
    bench = Bench("charger", product_code=7, revision=8, serial=9)
    lss = bench.master.lss
    lss.RESPONSE_TIMEOUT = 0.01
    assert lss.send_switch_state_selective(0x24E, 7, 8, 9)
    assert [lss.inquire_lss_address(command) for command in range(0x5A, 0x5E)] == [0x24E, 7, 8, 9]
    assert lss.inquire_node_id() == 99
    lss.configure_node_id(42)
    with pytest.raises(LssError):
        lss.configure_node_id(0)
    lss.configure_bit_timing(2)
    with pytest.raises(LssError):
        lss.configure_bit_timing(5)
    lss.store_configuration()
    lss.send_switch_state_global(lss.WAITING_STATE)
    with pytest.raises(LssError):
        lss.inquire_node_id()
    bench.master.nmt.send_command(0x82)
    assert bench.sent[-1:] == BOOTED_AS_42
    assert value(bench, 0x06) == 42


@pytest.mark.spec("C-051", "C-052", "C-059", "A-38")
def test_of_two_chargers_the_one_with_the_serial_number_is_moved():
    first = Bench.of({"one": ("charger", 98), "two": ("charger", 99)})
    select = ["40 4E020000", "41 01000000", "42 00000100", "43 02000000"]
    frames = [f"7E5#{frame.replace(' ', '')}000000" for frame in select]
    first["two"].power_off()
    first["two"].power_on(serial=2)
    assert [first.send(frame) for frame in frames] == [[], [], [], ["7E4#4400000000000000"]]
    assert first.send(INQUIRE_NODE_ID) == ["7E4#5E63000000000000"]
    first.send(WAIT)
    assert first.send(INQUIRE_NODE_ID) == []
