import pytest
from canopen.lss import LssError
from hypothesis import given, settings
from hypothesis import strategies as st

from canopen_twins.bench.bench import Bench
from canopen_twins.bus.frame import Frame
from canopen_twins.device.device import Device
from canopen_twins.slave.lss import LssSlave, Stored

SELECT = [
    "7E5#40C4010000000000",
    "7E5#4100000000000000",
    "7E5#4209000000000000",
    "7E5#4301000000000000",
]
CONFIGURE, WAIT = "7E5#0401000000000000", "7E5#0400000000000000"


class Settable(Device):
    """A device whose node id and bit rate LSS may change."""

    eds = "topcon.eds"
    title = "probe"

    def __init__(self, **given):
        self.pending = self.active = 5
        self.pending_rate = self.rate = 4
        self.outcome = Stored.DONE
        self.kept = None
        super().__init__(**given)

    @property
    def node_id(self):
        return self.active

    def services(self, slave):
        yield LssSlave(slave, self)

    def reset_communication(self):
        self.active, self.rate = self.pending, self.pending_rate

    def configure_node_id(self, node_id):
        if not 1 <= node_id <= 127:
            return False
        self.pending = node_id
        return True

    def configure_bit_timing(self, table, index):
        if table or index == 5 or index > 8:
            return False
        self.pending_rate = index
        return True

    def activate_bit_timing(self):
        self.rate = self.pending_rate

    def store(self):
        self.kept = self.pending
        return self.outcome


@pytest.fixture
def bench():
    return Bench.of({"probe": Settable()})


@pytest.fixture
def lss(bench):
    master = bench.master.lss
    master.RESPONSE_TIMEOUT = 0.01
    return master


@pytest.mark.spec("C-051")
def test_switching_all_slaves_is_not_answered_but_acts(bench):
    assert bench.send("7E5#5E00000000000000") == []
    assert bench.send(CONFIGURE) == []
    assert bench.send("7E5#5E00000000000000") == ["7E4#5E05000000000000"]
    assert bench.send(WAIT) == []
    assert bench.send("7E5#5E00000000000000") == []


@pytest.mark.spec("C-051")
def test_a_mode_that_is_neither_waiting_nor_configuration_changes_nothing(bench):
    bench.send(CONFIGURE)
    bench.send("7E5#0402000000000000")
    assert bench.send("7E5#5E00000000000000") == ["7E4#5E05000000000000"]


@pytest.mark.spec("C-052")
def test_selecting_by_identity_is_answered_once_all_four_numbers_match(bench):
    assert [bench.send(frame) for frame in SELECT] == [[], [], [], ["7E4#4400000000000000"]]
    assert bench.send("7E5#5E00000000000000") == ["7E4#5E05000000000000"]


@pytest.mark.spec("C-052")
@pytest.mark.parametrize("wrong", range(4))
def test_one_number_that_differs_means_another_slave(bench, wrong):
    frames = [f[:7] + "EE" + f[9:] if n == wrong else f for n, f in enumerate(SELECT)]
    assert [bench.send(frame) for frame in frames] == [[], [], [], []]
    assert bench.send("7E5#5E00000000000000") == []


@pytest.mark.spec("C-052")
def test_the_numbers_have_to_come_in_their_order(bench):
    for frame in (SELECT[0], SELECT[2], SELECT[1], SELECT[3]):
        assert bench.send(frame) == []


@pytest.mark.spec("C-053")
@pytest.mark.parametrize(("node_id", "answer"), [(1, 0), (127, 0), (0, 1), (128, 1), (255, 1)])
def test_a_node_id_is_accepted_or_refused(bench, node_id, answer):
    bench.send(CONFIGURE)
    assert bench.send(f"7E5#11{node_id:02X}000000000000") == [f"7E4#11{answer:02X}000000000000"]


@pytest.mark.spec("C-056")
def test_a_new_node_id_acts_after_a_reset_and_not_before(bench):
    bench.send(CONFIGURE)
    bench.send("7E5#1109000000000000")
    assert bench.send("7E5#5E00000000000000") == ["7E4#5E05000000000000"]
    assert bench.send("000#8205") == ["709#00"]
    assert bench.send("605#4000100000000000") == []
    assert bench.send("609#4000100000000000") == ["589#4300100000000000"]


@pytest.mark.spec("C-054")
@pytest.mark.parametrize(
    ("selector", "index", "answer"), [(0, 2, 0), (0, 5, 1), (0, 9, 1), (1, 2, 1)]
)
def test_a_bit_timing_is_accepted_or_refused(bench, selector, index, answer):
    bench.send(CONFIGURE)
    frame = f"7E5#13{selector:02X}{index:02X}0000000000"
    assert bench.send(frame) == [f"7E4#13{answer:02X}000000000000"]


@pytest.mark.spec("C-055")
@pytest.mark.parametrize("outcome", Stored)
def test_storing_says_how_it_went(bench, outcome):
    bench.device.outcome = outcome
    bench.send(CONFIGURE)
    bench.send("7E5#1107000000000000")
    assert bench.send("7E5#1700000000000000") == [f"7E4#17{outcome:02X}000000000000"]
    assert bench.device.kept == 7


@pytest.mark.spec("C-057")
def test_activating_a_bit_timing_keeps_the_node_off_the_bus_for_twice_the_delay(bench):
    bench.sdo[0x1017].raw = 10
    bench.send(CONFIGURE)
    bench.send("7E5#1300020000000000")
    assert bench.send("7E5#1564000000000000") == []
    assert bench.run(0.099) == []
    assert bench.device.rate == 4
    assert bench.run(0.002) == []
    assert bench.device.rate == 2
    assert bench.send("605#4000100000000000") == []
    assert bench.run(0.095) == []
    assert bench.run(0.005) == ["705#7F"]
    assert bench.send("605#4000100000000000") == ["585#4300100000000000"]


def test_an_answer_that_is_late_is_lost_while_the_node_is_off_the_bus(bench):
    bench.send(CONFIGURE)
    bench.inject("sdo_late", seconds=0.05)
    assert bench.send("605#4000100000000000") == []
    bench.send("7E5#1564000000000000")
    assert bench.run(0.3) == []


def test_power_ends_the_silence_of_a_new_bit_timing(bench):
    bench.send(CONFIGURE)
    bench.send("7E5#15FFFF0000000000")
    bench.power_off()
    bench.power_on()
    assert bench.sent[-1] == "705#00"


@pytest.mark.spec("C-058")
def test_the_identity_can_be_inquired(bench, lss):
    lss.send_switch_state_global(lss.CONFIGURATION_STATE)
    assert lss.inquire_lss_address(0x5A) == 0x1C4
    assert lss.inquire_lss_address(0x5B) == 0
    assert lss.inquire_lss_address(0x5C) == 9
    assert lss.inquire_lss_address(0x5D) == 1
    assert lss.inquire_node_id() == 5


@pytest.mark.spec("C-059")
@pytest.mark.parametrize("command", [0x11, 0x13, 0x15, 0x17, 0x5A, 0x5B, 0x5C, 0x5D, 0x5E])
def test_a_waiting_slave_neither_answers_nor_obeys(bench, command):
    assert bench.send(f"7E5#{command:02X}07000000000000") == []
    assert bench.device.pending == 5
    assert bench.send("605#4000100000000000") != []


@pytest.mark.spec("C-050")
def test_canopens_master_selects_configures_and_stores(bench, lss):
    assert lss.send_switch_state_selective(0x1C4, 0, 9, 1)
    lss.configure_node_id(77)
    lss.configure_bit_timing(2)
    lss.store_configuration()
    lss.send_switch_state_global(lss.WAITING_STATE)
    assert (bench.device.pending, bench.device.pending_rate, bench.device.kept) == (77, 2, 77)
    assert bench.send("000#8200") == ["74D#00"]


def test_canopens_master_hears_a_refusal(bench, lss):
    lss.send_switch_state_global(lss.CONFIGURATION_STATE)
    with pytest.raises(LssError, match="1"):
        lss.configure_node_id(0)


def test_a_slave_in_the_range_identifies_itself_in_every_lss_state(bench):
    frames = ["46C4010000", "4700000000", "4808000000", "490A000000", "4A00000000", "4B02000000"]
    for switch in (WAIT, CONFIGURE):
        bench.send(switch)
        answers = [bench.send(f"7E5#{frame}000000") for frame in frames]
        assert answers == [[], [], [], [], [], ["7E4#4F00000000000000"]]


def test_a_slave_outside_the_range_does_not(bench):
    frames = ["46C4010000", "4700000000", "480A000000", "49FF000000", "4A00000000", "4B02000000"]
    assert [bench.send(f"7E5#{frame}000000") for frame in frames] == [[]] * 6


def test_a_node_with_a_node_id_keeps_out_of_a_fast_scan(bench, lss):
    assert bench.send("7E5#4C00000000000000") == []
    assert bench.send("7E5#5100000000800000") == []
    assert lss.fast_scan() == (False, None)


def test_lss_works_in_stopped(bench):
    bench.send("000#0205")
    bench.send(CONFIGURE)
    assert bench.send("7E5#5E00000000000000") == ["7E4#5E05000000000000"]


@pytest.mark.parametrize("reset", ["000#8105", "000#8205"])
def test_after_a_reset_the_slave_waits(bench, reset):
    bench.send(CONFIGURE)
    bench.send(reset)
    assert bench.send("7E5#5E00000000000000") == []


@pytest.mark.parametrize("frame", ["7E5#0401", "7E5#", "7E5#R", "000007E5#0401000000000000"])
def test_frames_of_another_form_are_no_requests(bench, frame):
    bench.send(frame)
    assert bench.send("7E5#5E00000000000000") == []


@settings(max_examples=200, derandomize=True)
@given(st.lists(st.binary(min_size=0, max_size=8).filter(lambda data: data[:1] != b"\x04")))
def test_nothing_configures_a_slave_that_was_not_switched(frames):
    bench = Bench.of({"probe": Settable()})
    for data in frames:
        answers = bench.put(Frame(0x7E5, data))
        assert all(answer.startswith("7E4#4F") for answer in answers)
    assert (bench.device.pending, bench.device.pending_rate, bench.device.kept) == (5, 4, None)
