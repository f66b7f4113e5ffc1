import pytest

ERROR = "inject: {error: {code: 0x1000}}"


def of_master(frames):
    return [
        frame for frame in frames if "#" in frame and " 085#" not in frame and "705#" not in frame
    ]


def test_a_step_may_come_so_long_after_the_one_above(played):
    frames, _ = played(
        """\
        - {at: 1, send: 111#}
        - {after: 0.5, send: 222#}
        - {after: 0, send: 333#}
        - {at: 1.2, send: 444#}
        - {after: 0.1, send: 555#}
        """
    )
    assert of_master(frames) == ["1 111#", "1.2 444#", "1.3 555#", "1.5 222#", "1.5 333#"]


def test_the_first_step_may_come_so_long_after_the_beginning(played):
    assert of_master(played("- {after: 0.25, send: 111#}\n")[0]) == ["0.25 111#"]


def test_a_step_is_repeated_and_the_next_comes_after_the_last_time(played):
    frames, _ = played(
        """\
        - {at: 1, send: 111#, every: 0.1, times: 3}
        - {after: 0.05, send: 222#, every: 0.01, times: 2}
        """
    )
    assert of_master(frames) == ["1 111#", "1.1 111#", "1.2 111#", "1.25 222#", "1.26 222#"]


def test_an_expectation_that_is_repeated_is_judged_every_time(played):
    _, outcomes = played(
        f"""\
        - {{at: 1, expect: {{emcy: none, within: 0.5}}, every: 1, times: 3}}
        - {{at: 2.2, {ERROR}}}
        """
    )
    assert outcomes == ["PASS 1.5 none came", "FAIL 2.2 1000/01/646C656966", "PASS 3.5 none came"]


def test_after_does_not_wait_for_what_is_expected_but_for_what_is_asked(played):
    frames, _ = played(
        """\
        - {at: 1, nmt: stop}
        - {at: 1, write: {Byte: 1}, timeout: 0.25, abort: none}
        - {after: 0.5, expect: {silence: true, within: 10}}
        - {after: 0.1, send: 111#}
        """
    )
    assert frames[-2:] == ["1.25 605#8000200000000405", "1.85 111#"]


@pytest.mark.parametrize(
    ("condition", "moment"),
    [
        ("{emcy: any}", 1),
        ("{emcy: {code: 0x2000}}", 2),
        ("{emcy: any, nth: 2}", 2),
        ("{frame: 085#00.20.xx*}", 2),
        ("{frame: 1xx#*, from: master}", 3),
        ("{heartbeat: any}", 0.4),
        ("{heartbeat: operational}", 3.2),
        ("{value: {Error history.Number of errors: {min: 1}}}", 1.000001),
        ("{state: operational}", 3),
        ("{state: operational, nth: 2}", 3.5),
        ("{write: {Producer heartbeat: 400}}", 0),
        ("{write: {Byte: any}}", 3.6),
        ("{write: {Byte: 7, Word: 0x0102}}", 3.7),
        ("{nmt: start}", 3),
        ("{nmt: pre-operational}", 3.4),
    ],
)
def test_a_step_may_come_when_something_happens(played, condition, moment):
    frames, outcomes = played(
        f"""\
        - {{when: {condition}, send: 777#}}
        - {{at: 0, write: {{Producer heartbeat: 400}}}}
        - {{at: 1, {ERROR}}}
        - {{at: 2, inject: {{error: {{code: 0x2000}}}}}}
        - {{at: 3, nmt: start}}
        - {{at: 3, send: 123#}}
        - {{at: 3.4, nmt: pre-operational}}
        - {{at: 3.5, send: 000#01.00}}
        - {{at: 3.6, send: 605#2F00200006000000}}
        - {{at: 3.7, send: 205#07.02.01}}
        """
    )
    assert [frame for frame in frames if "777#" in frame] == [f"{moment:g} 777#"]
    assert outcomes == []


def test_a_moment_that_never_comes_is_an_error_once_nothing_else_is_to_come(played):
    frames, outcomes = played(
        """\
        - {when: {emcy: any}, send: 777#}
        - {at: 2, expect: {emcy: none, within: 1}}
        """
    )
    assert outcomes == ["ERROR 63 its moment never came", "PASS 3 none came"]
    assert frames == ["0 705#00"]


def test_a_moment_is_waited_for_as_long_as_the_run_should_last(played):
    steps = "- {when: {heartbeat: any}, send: 777#}\n- {at: 0, write: {Producer heartbeat: 5000}}\n"
    assert played(f"{steps}duration: 0\n")[1] == ["ERROR 1e-06 its moment never came"]
    assert played(f"{steps}duration: 4\n")[1] == ["ERROR 4 its moment never came"]
    frames, outcomes = played(f"{steps}duration: 5\n")
    assert (frames[-1], outcomes) == ("5 777#", [])


def test_without_a_duration_a_moment_has_a_minute_from_the_last_thing_on(played):
    steps = """\
        - {{at: 1, write: {{Producer heartbeat: {}}}}}
        - {{when: {{heartbeat: any}}, write: {{Producer heartbeat: {}}}}}
        - {{when: {{heartbeat: any}}, send: 777#}}
        """
    frames, outcomes = played(steps.format(40000, 50000))
    assert (frames[-1], outcomes) == ("91 777#", [])
    assert played(steps.format(60000, 59000))[1] == []
    assert played(steps.format(60001, 59000))[1] == [
        "ERROR 61 its moment never came",
        "SKIP 61 left out after the error in line 5",
    ]


def test_what_ends_a_window_has_a_minute_as_well_and_no_longer_than_it_takes(played):
    steps = """\
        - {{at: 1, write: {{Producer heartbeat: {}}}}}
        - {{at: 1, expect: {{emcy: any, before: {{heartbeat: any}}}}}}
        """
    assert played(steps.format(500))[1] == ["FAIL 1.5 none came, before heartbeat: pre-operational"]
    assert played(steps.format(60000))[1] == [
        "FAIL 61 none came, before heartbeat: pre-operational"
    ]
    assert played(steps.format(60001))[1] == ["FAIL 61 none came"]


def test_a_moment_is_watched_for_from_the_step_above_on(played):
    frames, _ = played(
        f"""\
        - {{at: 1, {ERROR}}}
        - {{at: 2, clear: error}}
        - {{when: {{emcy: any}}, send: 777#}}
        - {{at: 3, {ERROR}}}
        """
    )
    assert [frame for frame in frames if "777#" in frame] == ["2 777#"]


def test_one_moment_after_the_other_not_both_at_once(played):
    frames, _ = played(
        f"""\
        - {{when: {{emcy: any}}, send: 111#}}
        - {{when: {{emcy: any}}, send: 222#}}
        - {{when: {{emcy: any, nth: 2}}, send: 333#}}
        - {{at: 1, {ERROR}}}
        - {{at: 2, clear: error}}
        - {{at: 3, {ERROR}}}
        - {{at: 4, clear: error}}
        """
    )
    assert of_master(frames) == ["1 111#", "2 222#", "4 333#"]


def test_two_things_of_one_microsecond_come_in_their_order(played):
    frames, _ = played(
        """\
        - {when: {emcy: {code: 0x1000}}, send: 111#}
        - {when: {emcy: any}, send: 222#}
        - {at: 1, inject: {error: {code: 0x1000}}}
        - {at: 1, inject: {error: {code: 0x2000}}}
        """
    )
    assert of_master(frames) == ["1 111#", "1 222#"]


@pytest.mark.parametrize(
    "conditions",
    [
        ["{nmt: start}", "{state: operational}", "{frame: 185#*}"],
        ["{nmt: reset-node}", "{state: initialising}", "{state: pre-operational}"],
        ["{state: initialising}", "{state: pre-operational}", "{frame: 705#00}"],
    ],
)
def test_a_command_a_state_and_its_frames_come_as_cause_and_effect(played, conditions):
    steps = "".join(f"- {{when: {each}, send: {n}11#}}\n" for n, each in enumerate(conditions, 1))
    frames, outcomes = played(
        f"{steps}- {{at: 1, nmt: start}}\n- {{at: 2, nmt: reset-node}}\nduration: 3\n"
    )
    assert outcomes == []
    assert [frame.split()[1] for frame in frames if "11#" in frame] == ["111#", "211#", "311#"]


def test_a_value_is_met_when_it_has_not_been_so_at_the_look_before(played):
    frames, _ = played(
        """\
        - {when: {value: {Byte: 1}}, send: 111#}
        - {when: {value: {Byte: 1}, nth: 2}, send: 222#}
        - {at: 1, write: {Byte: 1}}
        - {at: 2, write: {Byte: 2}}
        - {at: 3, write: {Byte: 1}}
        duration: 4
        """
    )
    moments = [frame for frame in frames if "111#" in frame or "222#" in frame]
    assert [moment.split()[1] for moment in moments] == ["111#", "222#"]
    first, second = (float(moment.split()[0]) for moment in moments)
    assert 1 <= first < 1.02
    assert 3 <= second < 3.02


def test_a_run_is_over_after_a_day(played):
    _, outcomes = played(
        """\
        - {at: 86400, expect: {emcy: none, within: 1}}
        - {after: 1, power: off}
        """
    )
    assert outcomes == [
        "ERROR 86400 the run ended before it was decided",
        "ERROR 86400 1 step from here on was not reached",
    ]


def test_a_state_is_entered_once_however_many_wait_for_states_of_the_node(played):
    frames, outcomes = played(
        """\
        - {at: 0, expect: {state: stopped, within: 9}}
        - {when: {state: stopped, nth: 2}, send: 111#}
        - {at: 1, nmt: stop}
        - {at: 2, nmt: start}
        - {at: 3, nmt: stop}
        - {at: 3.5, expect: {state: initialising, within: 1}}
        - {at: 4, nmt: start}
        """
    )
    assert "3 111#" in frames
    assert outcomes == ["PASS 1 stopped", "FAIL 4.5 only operational"]
