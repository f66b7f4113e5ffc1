"""Why a value does not hold, a state is not entered, and why somebody spoke who should not."""

import pytest

from canopen_twins.diagnosis.expected import (
    ExpectedCommand,
    ExpectedSilence,
    ExpectedState,
    ExpectedValues,
    ExpectedWrites,
)
from canopen_twins.diagnosis.why import why
from canopen_twins.scenario.actions import Expectation
from canopen_twins.scenario.frame_matchers import AnyFrame
from canopen_twins.slave.service import State

VOLTAGE, RUN = ExpectedValues([(0x2020, 0)]), ExpectedWrites([(0x2014, 0)])
OPERATIONAL = ExpectedState(State.OPERATIONAL)
RUN_BY_SDO = "605#2B14200001000000"


@pytest.fixture
def reasons_for():
    """What is said of something that was waited for, by the last frames of a bench."""

    def reasons_for(bench, expected, frames=20):
        records = bench.trace[-frames:] if frames else []
        return why(bench.twin.node, records, expected=expected)

    return reasons_for


def test_a_value_has_an_error_in_its_way_though_it_was_long_ago(topcon, reasons_for):
    topcon.inject("interlock_open")
    topcon.run(0.2)
    topcon.send(RUN_BY_SDO)
    assert reasons_for(topcon, VOLTAGE, frames=0) == [
        "active: 9000h interlock loop open",
        "without effect now: an error is active, and RUN waits for its reset (A-47), "
        "Run command (manual 7.3.9)",
        "see Actual voltage (manual 7.3.10)",
    ]


def test_what_the_frames_tell_is_not_told_twice(topcon, reasons_for):
    topcon.inject("interlock_open")
    topcon.run(0.2)
    topcon.send(RUN_BY_SDO)
    told = reasons_for(topcon, VOLTAGE)
    assert [line[:8] for line in told] == ["EMCY 900", "605#2B14", "see Actu"]


def test_a_value_of_a_device_that_is_content_has_its_section_only(topcon, charger, reasons_for):
    assert reasons_for(topcon, VOLTAGE) == ["see Actual voltage (manual 7.3.10)"]
    topcon.power_off()
    assert reasons_for(topcon, VOLTAGE) == ["the node is silent: its supply is off"]


def test_a_charger_says_what_blocks_its_release(charger, reasons_for):
    charger.send("609#2F0062010F000000")
    (line, *_) = reasons_for(charger, ExpectedValues([(0x6000, 1)]), frames=0)
    assert line.startswith("without effect now: 0x2002:02 bit 3 does not let CANopen release")


def test_a_state_needs_a_command_for_this_node(topcon, reasons_for):
    topcon.send("000#0106")
    assert reasons_for(topcon, OPERATIONAL) == [
        "the node is pre-operational, and no NMT command 01h came for it (manual 3.1)",
        "000#0106 is for node 6, this is node 5",
    ]
    assert reasons_for(topcon, ExpectedCommand()) == ["000#0106 is for node 6, this is node 5"]


def test_a_state_that_the_node_has_is_not_entered(topcon, reasons_for):
    topcon.send("000#0105")
    assert reasons_for(topcon, OPERATIONAL) == [
        "the node is operational, and has not entered it anew"
    ]
    topcon.send("000#0205")
    assert reasons_for(topcon, OPERATIONAL) == []


def test_a_write_may_also_come_with_an_rpdo(topcon, reasons_for):
    assert reasons_for(topcon, RUN) == ["Run command (manual 7.3.9) is in RPDO4, 505h"]
    topcon.send("605#2303140105050080")
    assert reasons_for(topcon, RUN)[-1] == (
        "Run command (manual 7.3.9) is in RPDO4, 505h, which is off: "
        "bit 31 of Receive PDO 4 Communication Parameter.COB-ID RPDO4 (manual 7.2.13) is set"
    )


@pytest.mark.parametrize(
    ("act", "line"),
    [
        ("605#4018100400000000", "585#4318100401000000 answers a request (manual 3.2)"),
        (
            "605#2B17100064000000",
            "705#7F is a heartbeat: Producer Heartbeat Time (manual 7.2.10) is 100 ms",
        ),
        ("000#8105", "705#00 is a boot-up (manual 3.1)"),
    ],
)
def test_who_should_be_silent_has_a_reason_to_speak(topcon, reasons_for, act, line):
    topcon.send(act)
    topcon.run(0.15)
    assert reasons_for(topcon, ExpectedSilence())[-1].startswith(line)
    assert Expectation(AnyFrame(by_master=True), within=1.0, never=True).expected is None


def test_a_pdo_has_its_transmission_type_as_a_reason(topcon, reasons_for):
    for frame in ("605#2F00180201000000", "000#0105", "080#"):
        topcon.send(frame)
    assert reasons_for(topcon, ExpectedSilence())[-1].endswith("(manual 7.2.15) is 1")


def test_an_emcy_breaks_a_silence(topcon, reasons_for):
    topcon.inject("error", number=0x23)
    topcon.run(0.01)
    assert (
        reasons_for(topcon, ExpectedSilence())[-1] == "085#0023032300000000 is an EMCY (manual 3.3)"
    )
