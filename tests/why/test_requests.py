import pytest

from canopen_twins import Bench
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Record
from canopen_twins.bus.wire import KEPT
from canopen_twins.diagnosis.why import TOLD, why

STOPPED = "not answered: the node was stopped, without SDO (manual 3.1, Tab. 7)"
READ, RUN = "605#4000100000000000", "605#2B14200001000000"


@pytest.mark.parametrize(
    ("request_", "reason"),
    [
        (
            "605#2B14200007000000",
            "no command 7: 0 stops, 1 runs, 2 resets, Run command (manual 7.3.9)",
        ),
        ("605#2B10200088130000", "5000 is above 4000, Voltage reference (manual 7.3.5)"),
        ("605#2F10200001000000", "1 bytes for an object of 2, Voltage reference (manual 7.3.5)"),
        ("605#2B00200000000000", "read only, Nominal voltage (manual 7.3.1)"),
        ("605#4018100900000000", "no such sub-index, Identity Object (manual 7.2.11)"),
        ("605#4012100000000000", "no such object, 0x1012:00"),
        ("605#A018100100000000", "there is no block transfer, Identity Object.Vendor ID"),
        ("605#0000000000000000", "a segment of no open transfer (manual 3.2)"),
        ("605#E018100100000000", "no such command (manual 3.2)"),
    ],
)
def test_a_refusal_is_told_as_the_device_means_it_with_its_object(
    topcon, reasons, request_, reason
):
    (told,) = reasons(topcon, request_)
    assert told.startswith(f"{request_} refused: {reason}")


def test_what_is_accepted_leaves_nothing_in_the_event_log(topcon, reasons):
    assert reasons(topcon, READ, "605#2B10200064000000", RUN, "000#0105", "205#6400", "185#R") == []
    events = topcon.twin.node.wire.events
    assert (len(events.refusals), len(events.strikes)) == (0, 0)


def test_the_event_log_is_bounded(topcon):
    for _ in range(KEPT + 1):
        topcon.send("605#4012100000000000")
        topcon.send("000#0205")
        topcon.send("000#8005")
    topcon.inject("sdo_silence")
    for _ in range(KEPT + 1):
        topcon.send(READ)
    events = topcon.twin.node.wire.events
    assert (len(events.refusals), len(events.strikes)) == (KEPT, KEPT)


def test_what_is_too_long_ago_is_not_guessed(topcon, reasons):
    topcon.send("000#0205")
    topcon.run(1.0)
    topcon.send(READ)
    for _ in range(KEPT):
        topcon.run(1.0)
        topcon.send("000#0105")
        topcon.send("000#8005")
    assert why(topcon.twin.node, topcon.trace) == []


def test_a_request_to_a_stopped_node_is_not_answered_also_when_it_goes_on_later(topcon, reasons):
    topcon.send("000#0205")
    topcon.run(1.0)
    topcon.send(READ)
    topcon.run(1.0)
    assert reasons(topcon, "000#0105", READ) == [f"{READ} {STOPPED}"]


def test_a_request_in_the_moment_of_the_stop_came_too_late(topcon, reasons):
    topcon.run(1.0)
    assert reasons(topcon, READ, "000#0205", READ) == [f"{READ} {STOPPED}"]


def test_without_power_the_node_is_silent_and_requests_are_lost(topcon, reasons):
    topcon.run(1.0)
    topcon.power_off()
    topcon.run(1.0)
    assert reasons(topcon, READ) == [
        f"{READ} not answered: the node was not on the bus (manual 3.1)",
        "the node is silent: its supply is off",
    ]
    topcon.power_on()
    assert reasons(topcon)[-1] == f"{READ} not answered: the node was not on the bus (manual 3.1)"


def test_a_gateway_says_what_keeps_it_from_communicating(reasons):
    gateway = Bench("gateway", node_id=5)
    gateway.run(1.0)
    gateway.inject("link_cut")
    gateway.run(2.0)
    reason = reasons(gateway)[-1]
    assert reason.startswith("the node is silent: its CANopen state is Undefined: governor running")
    assert "3071" in reason
    assert reason.endswith("12422 (manual 3, 9.3 to 9.5)")
    gateway.power_off()
    gateway.power_on()
    assert reasons(gateway)[-1].endswith(
        "governor in the start tests, gateway in the start tests, no errors (manual 3, 9.3 to 9.5)"
    )


def test_a_gateway_kept_in_its_bootloader_says_so(reasons):
    gateway = Bench("gateway", node_id=5)
    gateway.inject("bootloader")
    gateway.run(1.0)
    (reason,) = reasons(gateway)
    assert "gateway kept in the bootloader" in reason


def test_a_gateway_off_its_bus_says_so(reasons):
    gateway = Bench("gateway", node_id=5)
    gateway.run(1.0)
    gateway.inject("can2_bus_fault")
    gateway.run(1.0)
    (reason,) = reasons(gateway)
    assert reason.startswith("the node is off the bus: its CANopen state is Pre-Operational")
    assert "12423" in reason


def test_a_request_of_a_wrong_length_is_none(topcon, reasons):
    assert reasons(topcon, "605#4000") == [
        "605#4000 not answered: a request has 8 bytes, not 2 (manual 3.2)"
    ]


@pytest.mark.parametrize(
    ("fault", "parameters", "verb"),
    [
        ("sdo_silence", {}, "not answered"),
        ("sdo_late", {"seconds": 5.0}, "not answered"),
        ("sdo_late", {"seconds": 0.5}, "answered"),
        ("sdo_abort", {}, "refused"),
        ("sdo_wrong_index", {}, "answered"),
        ("frame_lost", {"frame": "585#*"}, "not answered"),
        ("frame_lost", {"frame": "605#*"}, "not answered"),
        ("bus_off", {}, "not answered"),
    ],
)
def test_a_fault_is_named_also_when_it_is_over(topcon, reasons, fault, parameters, verb):
    topcon.inject(fault, **parameters)
    topcon.send(READ)
    topcon.run(1.0)
    topcon.clear()
    assert reasons(topcon, RUN) == [f"{READ} {verb}: the fault {fault}"]


def test_each_strike_explains_one_request(topcon, reasons):
    topcon.inject("sdo_silence", times=1)
    assert reasons(topcon, READ, "000#0205", READ) == [
        f"{READ} not answered: the fault sdo_silence",
        f"{READ} {STOPPED}",
    ]


def test_segments_of_a_block_are_not_missing_an_answer(bench_of, reasons):
    bench = bench_of(block=True)
    segments = ["605#0101020304050607", "605#0208090A0B0C0D0E", "605#8311121314151617"]
    assert reasons(bench, "605#C406200000000000", *segments) == []
    assert bench.sent[-1] == "585#A2037F0000000000"


def test_the_last_segment_of_a_block_is_no_abort(bench_of, reasons):
    bench = bench_of(block=True)
    bench.device.content = b"123456789"
    assert reasons(bench, "605#A40421007F000000", "605#A300000000000000") == []
    assert bench.sent[-1].startswith("585#82")


def test_an_abort_that_nobody_noted_has_the_words_of_its_code(topcon):
    request, answer = Frame.parse(READ), Frame.parse("585#8000100000000206")
    records = [Record(0.0, request, ""), Record(0.0, answer, "topcon")]
    (told,) = why(topcon.twin.node, records)
    assert told == f"{READ} refused: Object does not exist, Device Type (manual 7.2.1)"


def test_what_is_accepted_in_vain_is_told_while_it_is_so(topcon, reasons):
    topcon.set(panel="local")
    assert reasons(topcon, "605#2B10200064000000", RUN) == [
        "605#2B10200064000000 accepted, without effect now: the panel is in control (manual 6),"
        " Voltage reference (manual 7.3.5)",
        f"{RUN} accepted, without effect now: the panel is in control (manual 6),"
        " Run command (manual 7.3.9)",
    ]
    assert reasons(topcon, "000#0105") == []  # which takes control back (6)


def test_run_waits_for_the_reset_of_an_error(topcon, reasons):
    topcon.inject("error", number=0x30)
    told = reasons(topcon, RUN)
    assert told[-1].startswith(f"{RUN} accepted, without effect now: an error is active")


def test_a_charger_says_who_may_release_it(charger, reasons):
    release = "609#2F0062010F000000"
    (told,) = reasons(charger, release)
    assert "0x2002:02 bit 3 does not let CANopen release (A-46)" in told
    charger.send("609#2F02200208000000")
    assert reasons(charger, release) == []
    charger.inject("error", key="hardware")
    assert "an error blocks the release until it is cleared (A-48)" in reasons(charger, release)[-1]
    assert "its cause is still there (A-35)" in reasons(charger, "609#2F0320010B000000")[-1]


def test_a_charger_says_that_its_hardware_release_is_open(charger, reasons):
    charger.send("609#2F02200208000000")
    charger.inject("hardware_release_lost")
    assert "the hardware release is open" in reasons(charger, "609#2F0062010F000000")[-1]


def test_a_node_id_waits_for_its_reset(charger, reasons):
    (told,) = reasons(charger, "609#2F02200605000000")
    assert "it acts after it is saved by 0x1010 and the node is reset" in told


def test_only_the_last_write_to_an_object_counts(charger, reasons):
    assert len(reasons(charger, *["609#2F0062010F000000"] * 3)) == 1


def test_the_last_lines_are_told_in_the_order_of_the_frames(topcon, reasons):
    topcon.send("000#0105")
    told = reasons(topcon, *[f"605#40{sub:02X}300000000000" for sub in range(8)], "205#8813")
    assert [line[:10] for line in told] == [
        *(f"605#40{sub:02X}30" for sub in range(4, 8)),
        "205#8813 R",
        "EMCY 8200h",
    ]
    assert len(told) == TOLD


def test_records_may_count_from_a_later_time(topcon):
    topcon.run(10.0)
    topcon.send("000#0205")
    topcon.run(1.0)
    topcon.send(READ)
    records = [record._replace(time=record.time - 10.0) for record in topcon.trace]
    topcon.run(1.0)
    topcon.send("000#0105")
    assert why(topcon.twin.node, records, since=10.0) == [f"{READ} {STOPPED}"]


def test_the_answers_of_others_are_not_asked_about(reasons):
    bench = Bench.of({"left": ("topcon", 5), "right": ("topcon", 6)})
    bench.send("605#4012100000000000")
    assert why(bench["right"].node, bench.trace) == []


def test_a_transfer_that_nobody_goes_on_with(topcon, reasons):
    topcon.send("605#4008100000000000")
    topcon.run(11.0)
    (told,) = reasons(topcon)
    assert told == (
        "605#4008100000000000 refused: nobody went on with the transfer,"
        " Manufacturer Device Name (manual 7.2.5)"
    )


def test_a_reset_whose_cause_lasts_says_that_it_was_in_vain(topcon, reasons):
    reset = "605#2B14200002000000"
    topcon.inject("interlock_open")
    topcon.run(0.1)
    assert reasons(topcon, reset)[-1] == (
        f"{reset} accepted, without effect now: the cause of an error is still there (A-49),"
        " Run command (manual 7.3.9)"
    )
    topcon.clear("interlock_open")
    assert not any(line.startswith(reset) for line in reasons(topcon, reset))


def test_a_time_out_that_is_too_short_is_none(charger, reasons):
    (told,) = reasons(charger, "609#2B02200490010000")
    assert "accepted, without effect now: below 500 ms it is kept as 0" in told
