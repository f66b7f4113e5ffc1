import pytest
from probe import Fixed, configure

from canopen_twins import Bench

SYNC = "080#"
TPDO_1, TPDO_2 = "185#", "285#"  # Level, Byte, type 254; Double word, type 1


def set_type(bench, number, kind):
    configure(bench, f"605#2F{number - 1:02X}1802{kind:02X}000000")


def set_inhibit(bench, tenths):
    """Of TPDO 1, in tenths of a millisecond; it has to be off meanwhile."""
    time = tenths.to_bytes(2, "little").hex()
    configure(bench, "605#2300180185010080", f"605#2B001803{time}0000", "605#2300180185010000")


def set_event_timer(bench, milliseconds):
    configure(bench, f"605#2B001805{milliseconds.to_bytes(2, 'little').hex()}0000")


def times(bench, frame):
    return [record.time for record in bench.trace if str(record.frame) == frame]


@pytest.mark.spec("T-142")
@pytest.mark.parametrize(
    ("kind", "sent"), [(1, [1] * 6), (2, [0, 1] * 3), (3, [0, 0, 1] * 2), (240, [0] * 239 + [1])]
)
def test_a_synchronous_tpdo_is_sent_with_every_nth_sync(operational, kind, sent):
    set_type(operational, 2, kind)
    assert [len(operational.send(SYNC)) for _ in sent] == sent


@pytest.mark.spec("T-040", "T-142")
def test_it_carries_the_values_of_that_sync(operational):
    operational.sdo["Double word"].raw = 0x01020304
    assert operational.send(SYNC) == [TPDO_2 + "04030201"]
    operational.sdo["Double word"].raw = 5
    assert operational.send(SYNC) == [TPDO_2 + "05000000"]


def test_syncs_count_from_operational(operational):
    set_type(operational, 2, 2)
    operational.send(SYNC)
    operational.send("000#8005")
    operational.send(SYNC)
    operational.send("000#0105")
    assert [len(operational.send(SYNC)) for _ in range(4)] == [0, 1, 0, 1]


def test_syncs_count_from_a_written_type(operational):
    set_type(operational, 2, 2)
    operational.send(SYNC)
    set_type(operational, 2, 2)
    assert [len(operational.send(SYNC)) for _ in range(4)] == [0, 1, 0, 1]


@pytest.mark.parametrize("frame", ["080#R", "00000080#", "081#"])
def test_what_is_no_sync_sends_nothing(operational, frame):
    assert operational.send(frame) == []


@pytest.mark.parametrize("frame", ["080#07", "080#0102030405060708"])
def test_a_sync_may_carry_a_counter(operational, frame):
    assert operational.send(frame) == [TPDO_2 + "00000000"]


@pytest.mark.spec("T-112")
def test_a_new_sync_identifier_acts_at_once(operational):
    configure(operational, "605#2305100090000000")
    assert operational.send(SYNC) == []
    assert operational.send("090#") == [TPDO_2 + "00000000"]


@pytest.mark.parametrize("kind", [253, 254, 255])
def test_other_types_know_no_sync(bench, kind):
    set_type(bench, 2, kind)
    bench.send("000#0105")
    assert [bench.send(SYNC) for _ in range(260)] == [[]] * 260


def test_type_0_is_sent_with_the_sync_after_a_change(operational):
    set_type(operational, 2, 0)
    assert [len(operational.send(SYNC)) for _ in range(3)] == [1, 0, 0]
    operational.sdo["Double word"].raw = 5
    assert operational.run(1.0) == []
    assert [operational.send(SYNC) for _ in range(2)] == [[TPDO_2 + "05000000"], []]


@pytest.mark.spec("T-143")
def test_type_252_is_composed_at_sync_and_sent_on_request(operational):
    set_type(operational, 2, 252)
    operational.sdo["Double word"].raw = 1
    assert operational.send(SYNC) == []
    operational.sdo["Double word"].raw = 2
    assert operational.send("285#R") == [TPDO_2 + "01000000"]
    operational.send(SYNC)
    assert operational.send("285#R") == [TPDO_2 + "02000000"]


def test_type_252_before_any_sync_is_composed_on_request(operational):
    set_type(operational, 2, 252)
    operational.sdo["Double word"].raw = 1
    assert operational.send("285#R") == [TPDO_2 + "01000000"]


@pytest.mark.spec("T-144")
def test_type_253_is_composed_and_sent_on_request(operational):
    set_type(operational, 2, 253)
    for value in (1, 2):
        operational.sdo["Double word"].raw = value
        assert operational.send(SYNC) == []
        assert operational.send("285#R") == [f"285#0{value}000000"]


def test_a_synchronous_tpdo_may_be_asked_for_what_it_sent_last(operational):
    operational.sdo["Double word"].raw = 1
    operational.send(SYNC)
    operational.sdo["Double word"].raw = 2
    assert operational.send("285#R") == [TPDO_2 + "01000000"]


def test_an_event_driven_tpdo_may_be_asked_for_what_there_is_now(bench_of):
    bench = bench_of(tpdo_on_change=False)
    bench.send("000#0105")
    bench.inject("level", value=7)
    assert bench.send("185#R") == [TPDO_1 + "070000"]


@pytest.mark.parametrize("frame", ["185#", "185#000000", "00000185#R", "186#R"])
def test_what_is_no_request_for_a_tpdo_is_not_answered(operational, frame):
    assert operational.send(frame) == []


def test_a_tpdo_with_bit_30_is_not_sent_on_request(operational):
    configure(operational, "605#2301180185020080", "605#2301180185020040")
    assert operational.send("285#R") == []
    assert operational.send(SYNC) == [TPDO_2 + "00000000"]


@pytest.mark.spec("T-146")
def test_a_new_identifier_is_answered_and_the_old_one_is_dead(operational):
    configure(operational, "605#2301180190020080", "605#2301180190020000")
    assert operational.send("285#R") == []
    assert operational.send("290#R") == ["290#00000000"]
    assert operational.send(SYNC) == ["290#00000000"]


@pytest.mark.spec("T-140")
def test_a_tpdo_that_does_not_exist_sends_nothing(operational):
    configure(operational, "605#2301180185020080")
    assert operational.send("285#R") == []
    assert operational.send(SYNC) == []


@pytest.mark.spec("T-147")
@pytest.mark.parametrize("kind", [0, 1, 252, 253, 254])
def test_a_tpdo_with_nothing_mapped_sends_nothing(kind):
    operational = Bench.of({"probe": Fixed()})
    operational.send("000#0105")
    set_type(operational, 3, kind)
    assert [operational.send(frame) for frame in (SYNC, "385#R", "000#8005", "000#0105")][:3] == [
        [TPDO_2 + "00000000"],
        [],
        [],
    ]
    assert "385" not in {frame[:3] for frame in operational.sent}


@pytest.mark.parametrize("kind", [254, 255])
def test_an_event_driven_tpdo_is_sent_once_with_operational(bench, kind):
    set_type(bench, 1, kind)
    assert bench.send("000#0105") == [TPDO_1 + "000000"]
    assert bench.run(10.0) == []


def test_it_is_sent_when_its_content_changes_and_not_otherwise(operational):
    assert operational.send("605#2B00210034120000")[1:] == [TPDO_1 + "341200"]
    assert operational.send("605#2B00210034120000")[1:] == []
    assert operational.send("605#2B01200001000000")[1:] == []  # not mapped
    operational.inject("level", value=5)
    assert operational.sent[-1] == TPDO_1 + "050000"


def test_the_profile_says_whether_a_change_is_an_event(bench_of):
    bench = bench_of(tpdo_on_change=False)
    bench.send("000#0105")
    assert len(bench.send("605#2B00210034120000")) == 1


def test_without_changes_as_events_it_is_sent_once_with_operational_all_the_same(bench_of):
    bench = bench_of(tpdo_on_change=False)
    assert bench.send("000#0105") == [TPDO_1 + "000000"]


def test_a_tpdo_without_times_in_the_dictionary_is_sent_on_change_all_the_same(bench):
    set_type(bench, 2, 254)
    bench.send("000#0105")
    assert bench.send("605#2302200005000000")[1:] == [TPDO_2 + "05000000"]
    assert bench.run(1.0) == []


def test_a_change_while_pdos_are_off_is_sent_with_operational(operational):
    operational.send("000#8005")
    assert len(operational.send("605#2B00210034120000")) == 1
    assert operational.send("000#0105") == [TPDO_1 + "341200"]


@pytest.fixture
def inhibited(bench):
    """TPDO 1 has an inhibit time of 100 ms and is free to be sent, at 1 s."""
    set_inhibit(bench, 1000)
    bench.send("000#0105")
    bench.run(1.0)
    return bench


def test_a_change_during_the_inhibit_time_is_sent_at_its_end_with_the_last_value(inhibited):
    inhibited.inject("level", value=1)
    assert inhibited.sent[-1] == TPDO_1 + "010000"
    start = len(inhibited.sent)
    inhibited.run(0.03)
    for value in (2, 3):
        inhibited.inject("level", value=value)
    assert inhibited.sent[start:] == []
    assert inhibited.run(0.069) == []
    assert inhibited.run(0.001) == [TPDO_1 + "030000"]
    assert inhibited.run(1.0) == []


def test_the_inhibit_time_begins_anew_with_every_transmission(inhibited):
    inhibited.inject("level", value=1)
    inhibited.inject("level", value=2)
    inhibited.run(0.15)
    inhibited.inject("level", value=3)
    inhibited.run(0.1)
    assert times(inhibited, TPDO_1 + "020000") == [1.1]
    assert times(inhibited, TPDO_1 + "030000") == [1.2]


def test_a_change_that_is_taken_back_within_the_inhibit_time_is_not_sent(inhibited):
    for value in (1, 2, 1):
        inhibited.inject("level", value=value)
    assert inhibited.run(1.0) == []


def test_after_the_inhibit_time_a_change_is_sent_at_once(inhibited):
    inhibited.inject("level", value=1)
    inhibited.run(0.1)
    assert inhibited.send("605#2B00210034120000")[1:] == [TPDO_1 + "341200"]


def test_the_inhibit_time_counts_in_tenths_of_a_millisecond(bench):
    set_inhibit(bench, 7)
    bench.send("000#0105")
    bench.inject("level", value=2)
    bench.run(0.1)
    assert times(bench, TPDO_1 + "020000") == [0.0007]


def test_the_inhibit_time_is_over_with_operational(inhibited):
    inhibited.inject("level", value=1)
    inhibited.inject("level", value=2)
    inhibited.send("000#8005")
    assert inhibited.run(1.0) == []
    assert inhibited.send("000#0105") == [TPDO_1 + "020000"]


def test_an_old_inhibit_time_does_not_end_a_new_one(inhibited):
    inhibited.inject("level", value=1)
    inhibited.run(0.05)
    inhibited.send("000#8005")
    inhibited.send("000#0105")  # sent at 1.05 s
    inhibited.inject("level", value=2)
    inhibited.run(1.0)
    assert times(inhibited, TPDO_1 + "020000") == [1.15]


def test_the_inhibit_time_is_over_with_switching_off(inhibited):
    inhibited.inject("level", value=1)
    configure(inhibited, "605#2300180185010080")
    assert inhibited.send("605#2300180185010000")[1:] == [TPDO_1 + "010000"]


def test_synchronous_tpdos_have_no_inhibit_time(inhibited):
    set_type(inhibited, 1, 1)
    assert [inhibited.send(SYNC)[0] for _ in range(3)] == [TPDO_1 + "000000"] * 3


def test_an_event_timer_sends_without_a_change(operational):
    set_event_timer(operational, 70)
    operational.run(0.25)
    assert times(operational, TPDO_1 + "000000") == [0.0, 0.07, 0.14, 0.21]


def test_an_event_timer_begins_with_operational(bench):
    set_event_timer(bench, 70)
    assert bench.run(0.5) == []
    bench.send("000#0105")
    bench.run(0.15)
    assert times(bench, TPDO_1 + "000000") == [0.5, 0.57, 0.64]
    bench.send("000#0205")
    assert bench.run(1.0) == []


def test_an_event_timer_counts_from_the_last_transmission(operational):
    set_event_timer(operational, 100)
    operational.run(0.05)
    operational.inject("level", value=1)
    operational.run(0.21)
    assert times(operational, TPDO_1 + "010000") == [0.05, 0.15, 0.25]


def test_an_event_timer_sends_the_values_of_its_moment(operational):
    probe = operational.device
    probe.rest = 0

    def step(dt):
        probe.level = round(operational.clock.now * 1000)

    probe.step = step
    set_event_timer(operational, 20)
    operational.run(0.04)
    assert operational.sent[-1] == TPDO_1 + "280000"


def test_a_new_event_time_counts_from_its_write(operational):
    set_event_timer(operational, 100)
    operational.run(0.05)
    set_event_timer(operational, 200)
    operational.run(0.5)
    assert times(operational, TPDO_1 + "000000") == [0.0, 0.25, 0.45]


def test_event_time_0_stops_the_timer(operational):
    set_event_timer(operational, 100)
    set_event_timer(operational, 0)
    assert operational.run(1.0) == []


@pytest.mark.parametrize("kind", [0, 1, 252, 253])
def test_an_event_timer_is_for_event_driven_tpdos_only(operational, kind):
    set_event_timer(operational, 100)
    set_type(operational, 1, kind)
    operational.send(SYNC)
    assert operational.run(1.0) == []
    set_type(operational, 1, 255)
    assert operational.run(0.1) == [TPDO_1 + "000000"]


def test_an_event_timer_that_falls_into_the_inhibit_time_is_sent_at_its_end(inhibited):
    set_event_timer(inhibited, 70)
    inhibited.run(0.3)
    assert times(inhibited, TPDO_1 + "000000") == [0.0, 1.07, 1.17, 1.27]


def test_it_is_sent_then_once_and_not_after_the_next_inhibit_time(inhibited):
    set_event_timer(inhibited, 70)
    inhibited.run(0.15)
    set_event_timer(inhibited, 0)
    assert inhibited.run(0.2) == [TPDO_1 + "000000"]
    inhibited.inject("level", value=1)
    assert inhibited.run(1.0) == []


def test_a_tpdo_that_is_switched_off_is_not_sent_any_more(operational):
    set_event_timer(operational, 100)
    configure(operational, "605#2300180185010080")
    operational.inject("level", value=1)
    assert operational.run(1.0) == []


def test_an_event_driven_tpdo_is_sent_once_when_it_is_switched_on(operational):
    configure(operational, "605#2300180185010080")
    operational.inject("level", value=1)
    assert operational.send("605#2300180185010000") == ["585#6000180100000000", TPDO_1 + "010000"]
    assert operational.run(1.0) == []


def test_a_tpdo_that_is_switched_on_begins_anew(operational):
    set_type(operational, 2, 252)
    operational.send(SYNC)
    configure(
        operational,
        "605#2301180185020080",
        "605#2F011A0000000000",
        "605#23011A0110000120",
        "605#2F011A0001000000",
        "605#2301180185020000",
    )
    assert operational.send("285#R") == [TPDO_2 + "3412"]


def test_a_new_type_composes_anew(operational):
    operational.send(SYNC)
    operational.sdo["Double word"].raw = 5
    set_type(operational, 2, 252)
    assert operational.send("285#R") == [TPDO_2 + "05000000"]


def test_syncs_count_from_switching_on(operational):
    set_type(operational, 2, 2)
    operational.send(SYNC)
    configure(operational, "605#2301180185020080", "605#2301180185020000")
    assert [len(operational.send(SYNC)) for _ in range(4)] == [0, 1, 0, 1]


def test_nothing_is_sent_after_the_answer_that_confirms_it_off(operational):
    probe = operational.device
    probe.step = lambda dt: setattr(probe, "level", 9)
    operational.run(0.1)
    assert operational.send("605#2300180185010080") == ["585#6000180100000000"]


def test_the_inhibit_time_does_not_change_while_the_tpdo_exists(operational):
    # CiA 301, 7.5.2.37; CANopenNode and Lely answer so
    assert operational.send("605#2B00180307000000") == ["585#8000180330000906"]
    assert operational.send("605#4000180300000000") == ["585#4B00180300000000"]


def test_the_inhibit_time_may_be_confirmed_while_the_tpdo_exists(operational):
    configure(operational, "605#2B00180300000000")


@pytest.mark.spec("T-141")
@pytest.mark.parametrize("kind", [241, 251])
def test_a_reserved_transmission_type_is_refused_and_the_old_one_stays(bench, kind):
    assert bench.send(f"605#2F001802{kind:02X}000000") == ["585#8000180230000906"]
    assert bench.send("605#4000180200000000") == ["585#4F001802FE000000"]


@pytest.mark.spec("T-122")
@pytest.mark.parametrize("kind", [241, 252, 253])
def test_an_rpdo_has_no_such_type(bench, kind):
    assert bench.send(f"605#2F001402{kind:02X}000000") == ["585#8000140230000906"]


@pytest.mark.spec("T-145")
@pytest.mark.parametrize(
    ("record", "profile"),
    [("0014", {"rpdo_types": {254}}), ("0018", {"tpdo_types": {254}})],
)
def test_the_profile_says_which_types_are_offered(bench_of, record, profile):
    bench = bench_of(**profile)
    assert bench.send(f"605#2F{record}0201000000") == [f"585#80{record}0230000906"]
    configure(bench, f"605#2F{record}02FE000000")
