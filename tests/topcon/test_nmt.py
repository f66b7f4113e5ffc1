import pytest

from canopen_twins import Bench

from .bus import (
    ENTER_PREOP,
    RESET_COMMUNICATION,
    RESET_NODE,
    START,
    STOP,
    SYNC,
    refused,
    run,
    state_of_output,
)

SHOWS = {START: "705#05", STOP: "705#04", ENTER_PREOP: "705#7F"}
STATES = list(SHOWS)
READ_DEVICE_TYPE, DEVICE_TYPE = "605#4000100000000000", "585#4300100000000000"


@pytest.fixture
def beating(topcon):
    """A TopCon that shows its state every millisecond."""
    topcon.sdo["Producer Heartbeat Time"].raw = 1
    return topcon


def state(bench):
    (beat,) = bench.run(0.001)
    return beat


@pytest.mark.spec("T-010", "T-014", "A-01")
def test_after_power_on_the_node_boots_up_and_is_pre_operational(beating):
    assert beating.sent[0] == "705#00"
    assert state(beating) == "705#7F"
    assert beating.send("185#R") == []


@pytest.mark.spec("T-010", "T-037")
def test_sdo_answers_without_any_nmt_command(topcon):
    assert topcon.send(READ_DEVICE_TYPE) == [DEVICE_TYPE]


@pytest.mark.spec("T-017", "T-062", "A-01", "A-02")
@pytest.mark.parametrize("command", STATES)
@pytest.mark.parametrize("before", STATES)
def test_a_command_leads_to_its_state_from_every_state(beating, before, command):
    beating.send(before)
    assert beating.send(command) == []  # and no boot-up message
    assert state(beating) == SHOWS[command]


@pytest.mark.spec("T-014", "T-017", "A-01")
@pytest.mark.parametrize("command", [RESET_NODE, RESET_COMMUNICATION])
@pytest.mark.parametrize("before", STATES)
def test_a_reset_leads_to_boot_up_and_pre_operational_from_every_state(topcon, before, command):
    topcon.send(before)
    assert topcon.send(command) == ["705#00"]
    topcon.sdo["Producer Heartbeat Time"].raw = 1
    assert state(topcon) == "705#7F"


@pytest.mark.spec("T-014")
def test_nothing_but_an_end_of_initialisation_is_a_boot_up(topcon):
    for command in (START, STOP, ENTER_PREOP, START, "000#0100", ENTER_PREOP):
        topcon.send(command)
    topcon.run(10)
    assert topcon.sent == ["705#00"]
    topcon.power_off()
    topcon.power_on()
    assert topcon.sent == ["705#00", "705#00"]


@pytest.mark.spec("T-013")
@pytest.mark.parametrize("before", STATES)
def test_other_nodes_unknown_commands_and_wrong_lengths_change_nothing(beating, before):
    known = {0x01, 0x02, 0x80, 0x81, 0x82}
    unknown = [f"000#{command:02X}05" for command in range(256) if command not in known]
    others = [f"000#{command:02X}{node:02X}" for command in known for node in (1, 4, 6, 127, 255)]
    lengths = ["000#", "000#01", "000#81", "000#010500", "000#0105000000000000", "000#R"]
    beating.send(before)
    for frame in [*unknown, *others, *lengths]:
        assert beating.send(frame) == []
        assert state(beating) == SHOWS[before], frame


@pytest.mark.spec("T-013")
def test_node_id_0_means_all():
    bench = Bench.of({"left": ("topcon", 5), "right": ("topcon", 6)})
    bench.send("000#0100")
    assert bench.send("185#R") + bench.send("186#R") == ["185#" + 16 * "0", "186#" + 16 * "0"]
    assert bench.send("000#8100") == ["705#00", "706#00"]


@pytest.mark.spec("T-015", "T-016", "T-018", "T-037", "T-058")
@pytest.mark.parametrize(
    ("command", "pdo", "sdo", "emcy"),
    [(ENTER_PREOP, False, True, True), (START, True, True, True), (STOP, False, False, False)],
)
def test_what_works_in_which_state(topcon, command, pdo, sdo, emcy):
    topcon.sdo["Transmit PDO 1 Communication Parameter"]["Transmission type"].raw = 1
    topcon.send(command)
    topcon.send("205#E803")
    assert bool(topcon.send("185#R")) == pdo
    assert bool(topcon.send(SYNC)) == pdo
    assert bool(topcon.send(READ_DEVICE_TYPE)) == sdo
    topcon.inject("error", number=0x23)
    assert (topcon.sent[-1] == "085#0023032300000000") == emcy
    topcon.send(ENTER_PREOP)
    assert topcon.sdo["Voltage reference"].raw == (1000 if pdo else 0)


@pytest.mark.spec("T-018")
def test_a_sync_before_operational_leaves_no_trace(topcon):
    topcon.sdo["Receive PDO 1 Communication Parameter"]["transmission type"].raw = 1
    topcon.sdo["Transmit PDO 1 Communication Parameter"]["Transmission type"].raw = 2
    topcon.send("205#E803")
    assert topcon.send(SYNC) == []
    topcon.send(START)
    assert [len(topcon.send(SYNC)) for _ in range(4)] == [0, 1, 0, 1]  # counted from here
    assert topcon.sdo["Voltage reference"].raw == 0


@pytest.mark.spec("T-019", "A-65", "A-69")
def test_the_node_sends_nothing_of_its_own_accord(topcon):
    topcon.send(START)
    run(topcon, voltage=2000)
    start = len(topcon.sent)
    topcon.run(3600)
    assert topcon.sent[start:] == []
    assert topcon.send("705#R") == []  # no node guarding
    assert topcon.send("080#") == topcon.send("100#000000000000") == []
    assert topcon.send("706#05") == []
    topcon.run(3600)
    assert topcon.sent[start:] == []


@pytest.mark.spec("T-019")
def test_the_node_cannot_be_made_a_producer_of_sync(topcon):
    with refused(0x06090030):
        topcon.sdo["COB-ID SYNC message"].raw = 0x40000080


@pytest.mark.spec("A-58")
def test_a_master_that_falls_silent_leaves_the_output_on(topcon):
    topcon.send(START)
    run(topcon, voltage=2000)
    topcon.run(24 * 3600)
    assert state_of_output(topcon) == 0x0003
