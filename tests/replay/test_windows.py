"""What an expectation sees, from when, and until when."""

from textwrap import dedent

import pytest
from services.declared import BASE, U32, entry

ERROR = "inject: {error: {code: 0x1000}}"


def test_something_has_to_come_before_something_else(played):
    _, outcomes = played(
        f"""\
        - {{at: 1, expect: {{emcy: any, before: {{nmt: stop}}}}}}
        - {{at: 1, expect: {{emcy: any, before: {{nmt: start}}}}}}
        - {{at: 1, expect: {{emcy: {{code: 0x2000}}, before: {{nmt: stop}}}}}}
        - {{at: 2, nmt: start}}
        - {{at: 3, {ERROR}}}
        - {{at: 4, nmt: stop}}
        """
    )
    assert outcomes == [
        "PASS 3 1000/01/646C656966",
        "FAIL 2 none came, before NMT start: start",
        "FAIL 4 only 1000/01/646C656966, before NMT stop: stop",
    ]


def test_what_comes_first_of_time_and_event_ends_the_window(played):
    _, outcomes = played(
        """\
        - {at: 1, expect: {emcy: any, within: 0.5, before: {nmt: start}}}
        - {at: 1, expect: {emcy: any, within: 2, before: {nmt: start}}}
        - {at: 1, expect: {emcy: none, within: 0.5, before: {nmt: start}}}
        - {at: 1, expect: {emcy: none, within: 2, before: {nmt: start, nth: 2}}}
        - {at: 2, nmt: start, every: 0.25, times: 2}
        """
    )
    assert outcomes == [
        "FAIL 1.5 none came",
        "FAIL 2 none came, before NMT start: start",
        "PASS 1.5 none came",
        "PASS 2.25 none came",
    ]


@pytest.mark.parametrize(
    ("expected", "outcome"),
    [
        ("never: {write: {Byte: 1}}, before: {state: operational}", "FAIL 2 Byte = 1"),
        ("never: {write: {Byte: 2}}, before: {state: operational}", "PASS 3 only Byte = 1"),
        ("never: {write: {Byte: any}}, within: 1", "FAIL 2 Byte = 1"),
        ("never: {write: {Byte: any}}, within: 0.999999", "PASS 2 none came"),
        ("never: {write: {Word: any, Byte: 1}}", "FAIL 2 Byte = 1"),
        ("never: {write: {Word: any}}", "PASS 4 none came"),
        ("never: {nmt: stop}", "PASS 4 only start"),
        ("never: {emcy: any}", "PASS 4 none came"),
        ("never: {value: {Byte: 1}}", "FAIL 2 Byte is 1"),
        ("never: {value: {Byte: 3}}", "PASS 4 Byte is 1"),
        ("never: {state: stopped}", "PASS 4 only operational"),
        ("write: {Byte: 1, Word: 5}, within: 10", "FAIL 11 none came"),
    ],
)
def test_something_must_never_come_until_then_or_in_the_whole_run(played, expected, outcome):
    _, outcomes = played(
        f"""\
        - {{at: 1, expect: {{{expected}}}}}
        - {{at: 2, write: {{Byte: 1}}}}
        - {{at: 3, nmt: start}}
        duration: 4
        """
    )
    assert outcomes == [outcome]


@pytest.mark.parametrize("event", ["state: stopped", "nmt: stop"])
def test_an_event_that_never_comes_leaves_the_window_open_to_the_end(played, event):
    _, outcomes = played(
        f"""\
        - {{at: 1, expect: {{emcy: any, before: {{{event}}}}}}}
        - {{at: 1, expect: {{heartbeat: any, before: {{{event}}}}}}}
        - {{at: 1, expect: {{never: {{emcy: any}}, before: {{{event}}}}}}}
        - {{at: 2, write: {{Producer heartbeat: 500}}}}
        duration: 3
        """
    )
    assert outcomes == ["FAIL 3 none came", "PASS 2.5 pre-operational", "PASS 3 none came"]


def test_a_window_that_something_has_opened_begins_behind_it(played):
    steps = """\
        - when: {emcy: any}
          expect: {write: {Byte: 1}, within: 0.5}
        - {at: 1, write: {Byte: 1}}
        - {at: 1, inject: {error: {code: 0x1000}}}
        """
    assert played(steps)[1] == ["FAIL 1.5 none came"]
    assert played(dedent(steps) + "- {at: 1.5, write: {Byte: 1}}\n")[1] == ["PASS 1.5 Byte = 1"]


def test_the_master_is_expected_to_withdraw_the_release_in_time(played):
    steps = """\
        - when: {{emcy: {{code: 0x1000}}}}
          expect: {{write: {{Byte: 0}}, within: 0.5}}
        - {{at: 1, inject: {{error: {{code: 0x1000}}}}}}
        - {{at: {at}, write: {{Byte: {value}}}}}
        """
    for at, value, outcome in (
        (1.2, 0, "PASS 1.2 Byte = 0"),
        (1.5, 0, "PASS 1.5 Byte = 0"),
        (1.500001, 0, "FAIL 1.5 none came"),
        (1.2, 1, "FAIL 1.5 only Byte = 1"),
    ):
        assert played(steps.format(at=at, value=value))[1] == [outcome]


def test_frames_and_silence_of_the_master(played):
    _, outcomes = played(
        """\
        - {at: 1, expect: {frame: 181#xx, from: master, within: 1}}
        - {at: 1, expect: {frame: 705#*, from: master, within: 1}}
        - {at: 1, expect: {silence: true, from: master, within: 0.4}}
        - {at: 1, expect: {silence: true, from: master, within: 0.5}}
        - {at: 1, expect: {frame: 181#01, within: 1}}
        - {at: 1.5, send: 181#01}
        """
    )
    assert outcomes == [
        "PASS 1.5 181#01",
        "FAIL 2 none came",
        "PASS 1.4 none came",
        "FAIL 1.5 181#01",
        "FAIL 2 none came",
    ]


@pytest.mark.parametrize(
    ("command", "kind"),
    [("000#0105", "PASS"), ("000#0100", "PASS"), ("000#0106", "FAIL"), ("000#0205", "FAIL")],
)
def test_a_command_is_meant_for_the_node_or_for_all(played, command, kind):
    _, (outcome,) = played(
        f"- {{at: 1, send: {command}}}\n- {{at: 1, expect: {{nmt: start, within: 0}}}}\n"
    )
    assert outcome.startswith(kind)


def test_a_state_is_entered_not_had(played):
    _, outcomes = played(
        """\
        - {at: 0, expect: {state: pre-operational, within: 0}}
        - {at: 1, expect: {state: pre-operational, within: 1}}
        - {at: 3, nmt: reset-communication}
        - {at: 3, expect: {state: pre-operational, within: 0}}
        - {at: 4, power: off}
        - {at: 4, expect: {state: initialising, within: 0}}
        """
    )
    assert outcomes == [
        "PASS 0 pre-operational",
        "FAIL 2 none came",
        "PASS 3 pre-operational",
        "PASS 4 initialising",
    ]


def test_each_node_is_expected_for_itself_and_none_of_them_is_the_master(loaded, judged):
    outcomes = judged(
        loaded(
            """\
            version: 1
            nodes: {left: {device: probe, node_id: 5}, right: {device: probe, node_id: 6}}
            steps:
              - {at: 1, node: left, inject: {error: {code: 0x1000}}}
              - {at: 1, node: left, expect: {emcy: any, within: 0}}
              - {at: 1, node: right, expect: {silence: true, within: 1}}
              - {at: 1, node: left, expect: {silence: true, from: master, within: 1}}
              - when: {node: right, nmt: start}
                node: left
                expect: {state: stopped, before: {node: right, state: stopped}}
              - {at: 3, node: right, nmt: start}
              - {at: 4, node: left, nmt: stop}
              - {at: 5, node: right, write: {Byte: 1}}
              - {at: 5, node: left, expect: {never: {write: {Byte: 1}}, within: 0}}
              - {at: 5, node: right, expect: {write: {Byte: 1}, within: 0}}
            """
        )
    )
    assert outcomes == [
        "PASS 1 1000/01/646C656966",
        "PASS 2 none came",
        "PASS 2 none came",
        "PASS 4 stopped",
        "PASS 5 none came",
        "PASS 5 Byte = 1",
    ]


def test_a_silent_node_has_no_value_not_even_any(played):
    _, outcomes = played(
        """\
        - {at: 1, power: off}
        - {at: 1, expect: {value: {Byte: any}}}
        - {at: 1, expect: {never: {value: {Byte: any}}, within: 1}}
        """
    )
    assert outcomes == ["FAIL 1 Byte is (silent)", "PASS 2 Byte is (silent)"]


@pytest.mark.parametrize(
    ("expected", "outcome"),
    [
        ("never: {frame: 111#*, from: master}, within: 0.5", "FAIL 1 111#01"),
        ("never: {frame: 222#*, from: master}, within: 1", "FAIL 2 222#"),
        ("never: {frame: 222#*, from: master}, within: 0.999999", "PASS 2 none came"),
        ("frame: 222#, from: master, before: {frame: 333#, from: master}", "PASS 2 222#"),
        (
            "frame: 333#, from: master, before: {frame: 222#, from: master}",
            "FAIL 2 none came, before 222# of the master: 222#",
        ),
        ("frame: 222#, from: master, before: {frame: 222#, from: master}", "PASS 2 222#"),
        ("never: {frame: 222#, from: master}, before: {frame: 222#, from: master}", "FAIL 2 222#"),
        (
            "frame: 111#*, from: master, before: {node: probe, state: stopped, nth: 2}",
            "PASS 1 111#01",
        ),
    ],
)
def test_both_ends_of_a_window_count_and_one_microsecond_has_an_order(played, expected, outcome):
    _, outcomes = played(
        f"""\
        - {{at: 1, send: 111#01}}
        - {{at: 1, expect: {{{expected}}}}}
        - {{at: 2, send: 222#}}
        - {{at: 2, send: 333#}}
        """
    )
    assert outcomes == [outcome]


def test_the_third_of_one_microsecond_is_the_third(played):
    frames, _ = played(
        """\
        - {when: {frame: 111#*, from: master, nth: 3}, send: 777#}
        - {at: 1, send: 111#01}
        - {at: 1, send: 111#02, every: 0.5, times: 2}
        - {at: 1, send: 111#03}
        """
    )
    assert frames[-3:] == ["1 111#03", "1 777#", "1.5 111#02"]


def test_what_an_rpdo_writes_is_what_it_maps_at_that_moment(played):
    _, outcomes = played(
        """\
        - {at: 1, nmt: start}
        - {at: 1, expect: {write: {Word: 0x0102}, within: 3}}
        - {at: 1, expect: {never: {write: {Byte: any}}, within: 3}}
        - {at: 1.1, write: {RPDO 1.COB-ID: 0x80000205, RPDO 1 mapping.Number of mapped objects: 0}}
        - {after: 0, write: {0x1600:01: 0x20010010, 0x1600:00: 1, RPDO 1.COB-ID: 0x205}}
        - {at: 2, send: 205#0201}
        """
    )
    assert outcomes == ["PASS 2 Word = 0x0102", "PASS 4 none came"]


@pytest.mark.parametrize(
    ("ends", "frames"),
    [
        ("power: off", []),
        ("nmt: reset-node", ["1.2 000#8105", "1.2 705#00"]),
        ("nmt: reset-communication", ["1.2 000#8205", "1.2 705#00"]),
    ],
)
def test_an_answer_that_is_late_goes_with_the_device_that_owed_it(played, ends, frames):
    heard, outcomes = played(
        f"""\
        - {{at: 1, inject: {{sdo_late: {{seconds: 0.5}}}}}}
        - {{at: 1, write: {{Byte: 1}}, abort: none}}
        - {{at: 1.2, {ends}}}
        - {{at: 2, expect: {{silence: true, within: 1}}}}
        """
    )
    asked, given_up = "1 605#2F00200001000000", "2 605#8000200000000405"
    assert heard == ["0 705#00", asked, *frames, given_up]
    assert outcomes == ["PASS 2 Byte is not answered", "PASS 3 none came"]


def test_a_look_sees_what_time_alone_changes(loaded, judged, tmp_path):
    (tmp_path / "drive.eds").write_text(BASE + entry("1013", U32, 0), "ascii")
    scenario = loaded(
        """\
        version: 1
        nodes:
          drive: {device: drive.eds, node_id: 5}
          supply: {device: topcon, node_id: 6, settings: {load: resistor 4, noise: 3}}
        steps:
          - at: 0
            node: supply
            write: {Voltage reference: 2000, Current reference: 4000, Run command: 1}
          - {at: 10, node: supply, expect: {value: {Actual voltage: 2003}, within: 1}}
          - {at: 11, node: drive, expect: {value: {Entry 1013: {min: 11500000}}, within: 1}}
        """
    )
    assert judged(scenario) == [
        "PASS 10.024 Actual voltage is 2003",
        "PASS 11.5 Entry 1013 is 11500001",
    ]
