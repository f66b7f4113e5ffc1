import pytest
from probe import Probe, configure

from canopen_twins import Bench
from canopen_twins.slave.emcy import NO_ERROR, Emcy, read_emcy_table

FIELD = "6669656C64"  # what the probe puts into the manufacturer-specific field
OVER_CURRENT = "085#102303" + FIELD  # with register 03h
OVER_TEMPERATURE = "085#104209" + FIELD
BOTH = "085#10420B" + FIELD
GONE = "085#0000000000000000"


@pytest.fixture
def log(bench):
    """What the node has sent since it was last looked at, but for answers."""
    start = len(bench.sent)

    def log():
        nonlocal start
        sent, start = bench.sent[start:], len(bench.sent)
        return [frame for frame in sent if not frame.startswith(("585", "705"))]

    return log


def over_current(bench):
    bench.inject("error", code=0x2310, register=0x03)


def raise_both(bench):
    emergencies = Emcy(0x2310, 0x03, b"field"), Emcy(0x4210, 0x09, b"field")
    set_errors(bench, *emergencies)


def set_errors(bench, *emergencies):
    with bench.twin.node.acting() as probe:
        probe.emergencies = emergencies
    bench.segment.deliver()


def history(bench):
    count = bench.sdo["Error history"][0].raw
    return [bench.sdo["Error history"][sub].raw for sub in range(1, count + 1)]


@pytest.mark.spec("T-040", "T-050")
def test_code_register_and_field_are_sent_lowest_byte_first(bench, log):
    over_current(bench)
    assert log() == [OVER_CURRENT]


@pytest.mark.spec("T-051")
def test_an_error_is_told_once_while_it_lasts(bench, log):
    over_current(bench)
    log()
    for _ in range(3):
        bench.send("605#2B00210034120000")
        bench.run(1.0)
    assert log() == []


@pytest.mark.spec("T-053", "T-054")
def test_it_is_over_with_eight_zeros_and_told_anew_when_it_comes_again(bench, log):
    over_current(bench)
    bench.clear("error")
    over_current(bench)
    assert log() == [OVER_CURRENT, GONE, OVER_CURRENT]


@pytest.mark.spec("T-101", "T-102")
def test_the_register_has_the_bits_of_all_that_is_active(bench, log):
    set_errors(bench, Emcy(0x2310, 0x03, b"field"))
    raise_both(bench)
    assert log() == [OVER_CURRENT, BOTH]
    assert bench.sdo["Error register"].raw == 0x0B
    set_errors(bench, Emcy(0x4210, 0x09, b"field"))
    assert bench.sdo["Error register"].raw == 0x09
    set_errors(bench)
    assert bench.sdo["Error register"].raw == 0x00


def test_the_register_cannot_be_written(bench):
    assert bench.send("605#2F01100001000000") == ["585#8001100002000106"]


def test_of_several_errors_only_the_end_of_the_last_is_told(bench, log):
    raise_both(bench)
    log()
    set_errors(bench, Emcy(0x4210, 0x09, b"field"))
    assert log() == []
    set_errors(bench)
    assert log() == [GONE]


def test_errors_that_end_together_are_told_once(bench, log):
    raise_both(bench)
    log()
    set_errors(bench)
    assert log() == [GONE]


def test_an_error_that_follows_another_is_not_the_end_of_errors(bench, log):
    set_errors(bench, Emcy(0x2310, 0x03, b"field"))
    set_errors(bench, Emcy(0x4210, 0x09, b"field"))
    set_errors(bench)
    assert log() == [OVER_CURRENT, OVER_TEMPERATURE, GONE]


def test_a_device_says_itself_what_is_told_of_an_error_that_has_gone():
    class Talkative(Probe):
        @staticmethod
        def farewell(gone, register):
            return Emcy(0x0000, register, gone.code.to_bytes(5, "little"))

    bench = Bench.of({"probe": Talkative()})
    raise_both(bench)
    start = len(bench.sent)
    set_errors(bench)
    assert bench.sent[start:] == ["085#0000091023000000", "085#0000001042000000"]


@pytest.mark.spec("T-016", "T-058")
@pytest.mark.parametrize(("command", "sent"), [("000#8005", 1), ("000#0105", 1), ("000#0205", 0)])
def test_emergencies_are_sent_in_pre_operational_and_operational(bench, log, command, sent):
    bench.send(command)
    log()
    over_current(bench)
    assert log() == [OVER_CURRENT] * sent


def test_what_begins_in_stopped_is_told_afterwards_if_it_still_lasts(bench, log):
    bench.send("000#0205")
    over_current(bench)
    bench.run(1.0)
    assert log() == []
    bench.send("000#8005")
    assert log() == [OVER_CURRENT]
    bench.clear("error")
    assert log() == [GONE]


def test_what_begins_and_ends_in_stopped_is_kept_in_the_history_only(bench, log):
    bench.send("000#0205")
    over_current(bench)
    bench.clear("error")
    bench.send("000#8005")
    assert log() == []
    assert history(bench) == [0x66692310 & 0xFFFF | 0x6966 << 16]


def test_what_ends_in_stopped_is_told_afterwards(bench, log):
    over_current(bench)
    log()
    bench.send("000#0205")
    set_errors(bench, Emcy(0x2310, 0x03, b"field"), Emcy(0x4210, 0x09, b"field"))
    set_errors(bench, Emcy(0x4210, 0x09, b"field"))
    set_errors(bench)  # the last to go was never told
    bench.send("000#8005")
    assert log() == [GONE]


def test_reset_communication_keeps_errors_and_history_and_tells_nothing_again(bench, log):
    over_current(bench)
    log()
    bench.send("000#8205")
    assert log() == []
    assert bench.sdo["Error register"].raw == 0x03
    assert len(history(bench)) == 1
    bench.clear("error")
    assert log() == [GONE]


def test_reset_node_empties_the_history_and_tells_what_still_lasts(bench, log):
    raise_both(bench)
    set_errors(bench, Emcy(0x2310, 0x03, b"field"))
    log()
    bench.send("000#8105")
    assert log() == [OVER_CURRENT]
    assert len(history(bench)) == 1


def test_power_on_empties_the_history(bench):
    over_current(bench)
    bench.clear()
    bench.power_off()
    bench.power_on()
    assert history(bench) == []


def entry(code):
    return code | 0x6966 << 16


@pytest.mark.spec("T-103", "T-104")
def test_the_history_has_the_last_errors_newest_first(bench):
    assert history(bench) == []
    codes = (0x1001, 0x1002, 0x1003, 0x1004)
    for code in codes:
        bench.inject("error", code=code)
    assert history(bench) == [entry(code) for code in (0x1004, 0x1003, 0x1002)]


def test_the_end_of_an_error_is_not_in_the_history(bench):
    over_current(bench)
    bench.clear()
    assert history(bench) == [entry(0x2310)]


@pytest.mark.spec("T-105")
def test_writing_0_empties_the_history_and_nothing_else(bench, log):
    over_current(bench)
    log()
    configure(bench, "605#2F03100000000000")
    assert history(bench) == []
    assert bench.sdo["Error register"].raw == 0x03
    assert log() == []


@pytest.mark.spec("T-105")
@pytest.mark.parametrize("count", [1, 255])
def test_writing_another_number_is_refused(bench, count):
    over_current(bench)
    assert bench.send(f"605#2F031000{count:02X}000000") == ["585#8003100030000906"]
    assert history(bench) == [entry(0x2310)]


def test_an_unused_entry_of_the_history_reads_0(bench):
    assert bench.send("605#4003100100000000") == ["585#4303100100000000"]
    assert bench.send("605#4003100400000000") == ["585#8003100411000906"]


def test_the_profile_may_have_it_refused(bench_of):
    bench = bench_of(no_history_code=0x08000024)
    assert bench.send("605#4003100100000000") == ["585#8003100124000008"]


def test_emergencies_go_out_on_the_identifier_of_the_dictionary(bench, log):
    configure(bench, "605#2314100090000080", "605#2314100090000000")
    over_current(bench)
    assert log() == ["090#102303" + FIELD]


def test_an_emergency_that_does_not_exist_is_not_sent_then_or_later(bench, log):
    configure(bench, "605#2314100085000080")
    over_current(bench)
    assert bench.sdo["Error register"].raw == 0x03
    configure(bench, "605#2314100085000000")
    bench.run(1.0)
    assert log() == []
    bench.clear("error")
    assert log() == [GONE]


def test_an_error_is_told_at_the_moment_the_model_has_it(bench):
    probe = bench.device
    probe.rest = 0.25
    probe.step = lambda dt: setattr(probe, "emergencies", (Emcy(0x4210, 0x09, b"field"),))
    bench.send("605#4000100000000000")
    bench.run(1.0)
    assert str(bench.trace[-1]) == f"(0000000000.250000) can0 {OVER_TEMPERATURE}"


def test_an_error_of_communication_is_told_beside_those_of_the_device(bench, log):
    over_current(bench)
    with bench.twin.node.acting():
        bench.twin.node.slave.errors["node 127 is silent"] = 0x8130
    bench.segment.deliver()
    assert log() == [OVER_CURRENT, "085#3081130000000000"]
    assert bench.sdo["Error register"].raw == 0x13
    bench.clear("error")
    assert bench.sdo["Error register"].raw == 0x11
    with bench.twin.node.acting():
        bench.twin.node.slave.errors.clear()
    bench.segment.deliver()
    assert log() == [GONE]


def test_no_error_is_eight_zeros():
    assert (NO_ERROR.code, NO_ERROR.register, NO_ERROR.field) == (0, 0, bytes(5))


def test_a_table_of_messages_is_read_by_code_and_detail(tmp_path):
    table = tmp_path / "table.csv"
    table.write_text("code,register,detail,label\n2310,03,1FF,too much\n2310,03,0,much\n")
    assert read_emcy_table(str(table)) == {
        (0x2310, 0x1FF): Emcy(0x2310, 0x03, b"\xff\x01\0\0\0", "too much"),
        (0x2310, 0): Emcy(0x2310, 0x03, bytes(5), "much"),
    }


def test_a_row_that_stands_twice_in_a_table_is_a_bug(tmp_path):
    table = tmp_path / "table.csv"
    table.write_text("code,register,detail,label\n2310,03,1,one\n2310,05,1,other\n")
    with pytest.raises(ValueError, match="stands there twice"):
        read_emcy_table(str(table))
