import pytest

from canopen_twins.diagnosis.expected import ExpectedEmcy, ExpectedFrame, ExpectedHeartbeat
from canopen_twins.scenario.actions import Expectation
from canopen_twins.scenario.frame_matchers import FrameLike

PRE_OPERATIONAL = "the node was pre-operational, without PDO (manual 3.1, Tab. 7)"
REFUSED = "205#8813 RPDO1 refused: 5000 is above 4000, Voltage reference (manual 7.3.5)"
COB_ID_2 = "Transmit PDO 2 Communication Parameter.COB-ID TPDO2 (manual 7.2.15)"


@pytest.fixture
def operational(topcon):
    topcon.send("000#0105")
    topcon.run(1.0)
    return topcon


def test_outside_operational_no_pdo_is_taken_nor_sent(topcon, reasons):
    assert reasons(topcon, "205#6400", "185#R") == [
        f"205#6400 RPDO1 not taken: {PRE_OPERATIONAL}",
        f"185#R TPDO1 not sent: {PRE_OPERATIONAL}",
    ]


def test_an_rpdo_that_is_too_short_or_refused_has_its_reason(operational, reasons):
    told = reasons(operational, "205#64", "205#8813")
    assert told[0] == "205#64 RPDO1 not taken: 1 of 2 bytes (manual 3.5)"
    assert told[-1] == REFUSED


def test_an_rpdo_that_waits_for_sync_is_refused_with_it(operational, reasons):
    operational.send("605#2F00140201000000")
    assert reasons(operational, "205#8813") == []
    assert REFUSED in reasons(operational, "080#")


def test_a_refusal_belongs_to_the_frame_it_came_of(operational, reasons):
    operational.send("205#8813")
    operational.run(1.0)
    operational.twin.node.slave.entry(0x2010, 0).high = 5000
    told = reasons(operational, "205#8813")
    assert [line for line in told if line.startswith("205#")] == [REFUSED]


def test_a_pdo_that_is_off_says_where(operational, reasons):
    assert reasons(operational, "285#R") == [
        f"285#R TPDO2 not sent: it is off, bit 31 of {COB_ID_2} is set"
    ]
    (told,) = reasons(operational, "605#2301140105030080", "305#6400")[-1:]
    assert told.startswith("305#6400 RPDO2 not taken: it is off, bit 31 of Receive PDO 2 ")


def test_a_pdo_without_mapping_is_never_sent(operational, reasons):
    (told,) = reasons(operational, "605#2301180185020000", "285#R")
    assert told.startswith("285#R TPDO2 not sent: nothing is mapped in ")


def test_a_pdo_that_may_not_be_asked_for_is_not(bench, reasons):
    bench.send("000#0105")
    mapped = ("605#23021A0108000020", "605#2F021A0001000000")
    (told,) = reasons(bench, *mapped, "605#2302180185030040", "385#R")
    assert told.startswith("385#R TPDO3 not sent: bit 30 of ")


def test_a_pdo_on_its_way_may_be_lost(operational, reasons):
    operational.inject("frame_lost", frame="205#*", times=1)
    assert reasons(operational, "205#6400") == ["205#6400 RPDO1 not taken: the fault frame_lost"]


def test_an_rpdo_may_have_no_effect(charger, reasons):
    charger.send("000#0109")
    charger.run(1.0)
    (told,) = reasons(charger, "209#0F")
    assert told.startswith("209#0F RPDO1 without effect: 0x2002:02 bit 3 does not let CANopen")


def test_nmt_commands_that_are_none_are_not_obeyed(topcon, reasons):
    assert reasons(topcon, "000#0505", "000#05", "000#0106", "000#0105") == [
        "000#0505 not obeyed: there is no command 05h (manual 3.1)",
        "000#05 not obeyed: an NMT command has 2 bytes, not 1 (manual 3.1)",
    ]


def test_nmt_commands_to_a_node_without_power_are_lost(topcon, reasons):
    topcon.power_off()
    topcon.run(1.0)
    assert reasons(topcon, "000#0105") == [
        "000#0105 not obeyed: the node was not on the bus (manual 3.1)",
        "the node is silent: its supply is off",
    ]


def test_an_emergency_has_its_label_and_its_table(topcon, reasons):
    topcon.inject("error", number=0x30)
    (told,) = reasons(topcon)
    assert told.startswith("EMCY 3300h detail 30h: ")
    assert told.endswith(" (manual 8, Tab. 70)")


def test_an_emergency_that_says_nothing_more_is_left_out(bench, reasons):
    bench.inject("error", code=0x1000)
    assert reasons(bench) == []


EXPECTED = [
    (ExpectedFrame(0x185), "TPDO1: it comes on a remote request, "),
    (ExpectedFrame(0x285), f"TPDO2: it is off, bit 31 of {COB_ID_2} is set"),
    (ExpectedFrame(0x705), "there is no heartbeat: Producer Heartbeat Time (manual 7.2.10) is 0"),
    (ExpectedHeartbeat(), "there is no heartbeat: "),
    (ExpectedEmcy(), "no error is active (manual 3.3)"),
    (ExpectedFrame(0x085), "no error is active (manual 3.3)"),
]


@pytest.mark.parametrize(("expected", "reason"), EXPECTED)
def test_what_was_waited_for_in_vain_has_a_reason(operational, reasons, expected, reason):
    (told,) = reasons(operational, expected=expected)
    assert told.startswith(reason)


@pytest.mark.parametrize("expected", [None, ExpectedFrame(0x123)])
def test_what_nobody_can_tell_anything_about_is_left_alone(operational, reasons, expected):
    assert reasons(operational, expected=expected) == []


def test_a_tpdo_waits_for_operational_for_sync_or_for_its_mapping(topcon, reasons):
    (told,) = reasons(topcon, expected=ExpectedFrame(0x185))
    assert told == "TPDO1: the node is pre-operational, without PDO (manual 3.1, Tab. 7)"
    topcon.send("000#0105")
    (told,) = reasons(topcon, "605#2F00180201000000", expected=ExpectedFrame(0x185))
    assert told.startswith("TPDO1: it comes with a SYNC, ")
    (told,) = reasons(topcon, "605#2301180185020000", expected=ExpectedFrame(0x285))
    assert told.startswith("TPDO2: nothing is mapped in ")


def test_a_tpdo_with_moments_of_its_own_says_so(charger, reasons):
    (told,) = reasons(charger, "000#0109", expected=ExpectedFrame(0x189))
    assert told == "TPDO1: it has its own moments (manual, PDO Transfer)"


def test_an_error_is_told_once_and_not_in_stopped(topcon, reasons):
    topcon.inject("error", number=0x30)
    told = reasons(topcon, expected=ExpectedEmcy())[-1]
    assert told.startswith("active, and told when they came: 3300h ")
    topcon.send("000#0205")
    assert reasons(topcon, expected=ExpectedEmcy())[-1] == (
        "no EMCY: the node is stopped (manual 3.1, Tab. 7)"
    )


def test_emergencies_may_be_switched_off(bench, reasons):
    bench.send("605#2314100085000080")
    told = reasons(bench, expected=ExpectedEmcy())
    assert told[-1].startswith("no EMCY: bit 31 of ")


def test_a_heartbeat_that_runs_is_not_missing(topcon, reasons):
    assert reasons(topcon, "605#2B171000E8030000", expected=ExpectedHeartbeat()) == []


@pytest.mark.parametrize(
    ("fault", "parameters", "expected", "frame"),
    [
        ("heartbeat_stopped", {}, ExpectedHeartbeat(), "705#05"),
        ("pdo_missing", {}, ExpectedFrame(0x185), "185#0000000000000000"),
        ("emcy_lost", {}, ExpectedEmcy(), "085#0033053000000000"),
    ],
)
def test_what_a_fault_has_struck_was_sent(operational, reasons, fault, parameters, expected, frame):
    operational.send("605#2B171000E8030000")
    operational.inject(fault, **parameters)
    operational.send("185#R")
    operational.run(1.0)
    operational.inject("error", number=0x30)
    operational.run(0.5)
    assert reasons(operational, expected=expected)[-1] == f"{frame} was sent: the fault {fault}"


def test_what_must_not_come_needs_no_reason_for_staying_away(operational, reasons):
    never = Expectation(FrameLike("185#*"), within=1.0, never=True)
    assert reasons(operational, expected=never.expected) == []
