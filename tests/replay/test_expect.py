import pytest

ERROR = "inject: {error: {code: 0x1000}}"  # EMCY 1000h, register 01h, error field "field"


@pytest.mark.parametrize(
    "fields",
    [
        "{code: 0x1000}",
        "{register: 1}",
        "{detail: 0x646C656966}",
        "{code: 0x1000, register: 0x01, detail: 0x646C656966}",
    ],
)
def test_an_emergency_is_expected_by_any_of_its_fields(played, fields):
    _, outcomes = played(
        f"""\
        - {{at: 1, {ERROR}}}
        - {{at: 1, expect: {{emcy: {fields}, within: 0}}}}
        """
    )
    assert outcomes == ["PASS 1 1000/01/646C656966"]


@pytest.mark.parametrize("fields", ["{code: 0x1001}", "{code: 0x1000, register: 3}", "{detail: 0}"])
def test_an_emergency_that_differs_in_one_field_is_told_and_not_taken(played, fields):
    _, outcomes = played(
        f"""\
        - {{at: 1, {ERROR}}}
        - {{at: 1, expect: {{emcy: {fields}, within: 0.5}}}}
        """
    )
    assert outcomes == ["FAIL 1.5 only 1000/01/646C656966"]


def test_the_emergency_is_heard_on_the_identifier_of_the_dictionary(played):
    _, outcomes = played(
        f"""\
        - {{at: 0, write: {{COB-ID EMCY: 0x800001A5}}}}
        - {{at: 0, write: {{COB-ID EMCY: 0x1A5}}}}
        - {{at: 1, {ERROR}}}
        - {{at: 1, expect: {{frame: 1A5#00.10.xx.6x.69.65.6c.64, within: 0}}}}
        - {{at: 1, expect: {{emcy: {{code: 0x1000}}, within: 0}}}}
        """
    )
    assert outcomes == ["PASS 1 1A5#0010016669656C64", "PASS 1 1000/01/646C656966"]


@pytest.mark.parametrize(
    ("steps", "none", "some"),
    [
        (["0.999999 error", "1 expect"], "PASS 1.5 none came", "FAIL 1.5 none came"),
        (["1 error", "1 expect"], "FAIL 1 1000/01/646C656966", "PASS 1 1000/01/646C656966"),
        (["1 expect", "1.5 error"], "FAIL 1.5 1000/01/646C656966", "PASS 1.5 1000/01/646C656966"),
        (["1 expect", "1.500001 error"], "PASS 1.5 none came", "FAIL 1.5 none came"),
    ],
)
def test_the_time_begins_with_the_moment_of_the_step_and_both_ends_count(played, steps, none, some):
    for expected, outcome in (("none", none), ("{code: 0x1000}", some)):
        verbs = {"error": ERROR, "expect": f"expect: {{emcy: {expected}, within: 0.5}}"}
        told = [step.split() for step in steps]
        _, outcomes = played("".join(f"- {{at: {at}, {verbs[verb]}}}\n" for at, verb in told))
        assert outcomes == [outcome]


def test_what_a_timer_sends_at_the_last_moment_counts(played):
    _, outcomes = played(
        """\
        - {at: 0, write: {Producer heartbeat: 100}}
        - {at: 0.05, expect: {heartbeat: pre-operational, within: 0.05}}
        - {at: 0.1, expect: {heartbeat: pre-operational, within: 0}}
        - {at: 0.11, expect: {heartbeat: pre-operational, within: 0.089999}}
        """
    )
    assert outcomes == [
        "PASS 0.1 pre-operational",
        "PASS 0.1 pre-operational",
        "FAIL 0.199999 none came",
    ]


@pytest.mark.parametrize(
    ("command", "state"),
    [("start", "operational"), ("stop", "stopped"), ("pre-operational", "pre-operational")],
)
def test_a_heartbeat_is_expected_by_its_state(played, command, state):
    _, outcomes = played(
        f"""\
        - {{at: 0, write: {{Producer heartbeat: 100}}}}
        - {{at: 1, nmt: {command}}}
        - {{at: 1.01, expect: {{heartbeat: operational, within: 0.2}}}}
        - {{at: 1.01, expect: {{heartbeat: pre-operational, within: 0.2}}}}
        - {{at: 1.01, expect: {{heartbeat: stopped, within: 0.2}}}}
        """
    )
    assert f"PASS 1.1 {state}" in outcomes
    assert outcomes.count(f"FAIL 1.21 only {state}, {state}") == 2


def test_a_boot_up_message_is_no_heartbeat(played):
    _, outcomes = played("- {at: 0, expect: {heartbeat: none, within: 1}}\n")
    assert outcomes == ["PASS 1 none came"]


def test_a_heartbeat_that_should_not_be_there_is_told(played):
    _, outcomes = played(
        """\
        - {at: 0, write: {Producer heartbeat: 100}}
        - {at: 0.2, expect: {heartbeat: none, within: 1}}
        """
    )
    assert outcomes == ["FAIL 0.2 pre-operational"]


@pytest.mark.parametrize(
    ("pattern", "kind"),
    [
        ("585#4308xxxxxxxxxxxx", "FAIL"),
        ("585#4B.08.20.00.08.08.00.00", "PASS"),
        ("585#4b082000xxxx0000", "PASS"),
        ("585#4b082000", "FAIL"),
        ("5x5#4b082000xxxx0000", "PASS"),
        ("585#R", "FAIL"),
        ("585#4b08*", "PASS"),
        ("585#43*", "FAIL"),
        ("605#40.08.20.00.00.00.00.00", "FAIL"),
    ],
)
def test_a_frame_of_the_node_is_expected_digit_by_digit(played, pattern, kind):
    _, (outcome,) = played(
        f"""\
        - {{at: 1, send: 605#4008200000000000}}
        - {{at: 1, expect: {{frame: {pattern}, within: 0}}}}
        """
    )
    assert outcome.startswith(kind)


def test_silence_means_the_node_and_not_the_scenario(played):
    _, outcomes = played(
        """\
        - {at: 1, send: 080#}
        - {at: 1, expect: {silence: true, within: 1}}
        - {at: 3, send: 605#4008200000000000}
        - {at: 3, expect: {silence: true, within: 1}}
        """
    )
    assert outcomes == ["PASS 2 none came", "FAIL 3 585#4B08200008080000"]


@pytest.mark.parametrize(
    ("wanted", "kind"),
    [
        ("50", "PASS"),
        ("0x32", "PASS"),
        ("50.0", "PASS"),
        ("51", "FAIL"),
        ("{is: 50}", "PASS"),
        ("{is: 52, tolerance: 2}", "PASS"),
        ("{is: 52, tolerance: 1.9}", "FAIL"),
        ("{is: 48, tolerance: 2}", "PASS"),
        ("{min: 50}", "PASS"),
        ("{min: 51}", "FAIL"),
        ("{max: 50}", "PASS"),
        ("{max: 49}", "FAIL"),
        ("{min: 49, max: 51}", "PASS"),
    ],
)
def test_a_value_is_expected_with_as_much_room_as_is_given(played, wanted, kind):
    _, (outcome,) = played(
        f"""\
        - {{at: 1, write: {{Limited: 50}}}}
        - {{at: 1, expect: {{value: {{Limited: {wanted}}}}}}}
        """
    )
    assert outcome.startswith(f"{kind} 1 Limited is ")


@pytest.mark.parametrize(
    ("named", "wanted", "outcome"),
    [
        ("Text", "text", "PASS 1 Text is 'text'"),
        ("Text", "test", "FAIL 1 Text is 'text'"),
        ("0x2001", "0x1234", "PASS 1 0x2001 is 0x1234"),
        ("0x2001:00", "0x1235", "FAIL 1 0x2001:00 is 0x1234"),
        ("0x200d:03", "3", "PASS 1 0x200d:03 is 3"),
        ("With a gap.Third", "4", "FAIL 1 With a gap.Third is 3"),
        ("Three bytes", "-2", "PASS 1 Three bytes is -2"),
        ("Refusing", "1", "FAIL 1 Refusing is (refused: always)"),
    ],
)
def test_objects_of_every_kind_are_looked_at(played, named, wanted, outcome):
    _, outcomes = played(f"- {{at: 1, expect: {{value: {{{named}: {wanted}}}}}}}\n")
    assert outcomes == [outcome]


def test_all_values_of_a_step_hold_at_the_same_moment(played):
    _, outcomes = played(
        """\
        - {at: 0, write: {Byte: 1, Word: 1}}
        - {at: 0, expect: {value: {Byte: 2, Word: 2}, within: 3}}
        - {at: 1, write: {Byte: 2}}
        - {at: 2, write: {Word: 2}}
        """
    )
    assert outcomes == ["PASS 2 Byte is 2, Word is 2"]


def test_a_value_that_never_comes_is_told_as_it_is_in_the_end(played):
    _, outcomes = played(
        """\
        - {at: 0, expect: {value: {Byte: 2}, within: 1}}
        - {at: 0.5, write: {Byte: 7}}
        """
    )
    assert outcomes == ["FAIL 1 Byte is 7"]


def test_a_silent_node_has_no_values(played):
    _, outcomes = played(
        """\
        - {at: 1, power: off}
        - {at: 1, expect: {value: {Word: 0x1234}}}
        - {at: 2, power: on}
        - {at: 2, expect: {value: {Word: 0x1234}}}
        """
    )
    assert outcomes == ["FAIL 1 Word is (silent)", "PASS 2 Word is 0x1234"]


def test_being_in_a_state_is_another_thing_than_entering_it(played):
    _, outcomes = played(
        """\
        - {at: 1, expect: {nmt_state: pre-operational}}
        - {at: 1, expect: {nmt_state: operational}}
        - {at: 1, expect: {nmt_state: operational, within: 1.5}}
        - {at: 1, expect: {state: pre-operational, within: 0.5}}
        - {at: 1, expect: {never: {nmt_state: stopped}}}
        - {at: 2, nmt: start}
        - {when: {nmt_state: operational}, power: off}
        - {after: 0, expect: {nmt_state: initialising}}
        """
    )
    assert [outcome.replace("  ", " ") for outcome in outcomes] == [
        "PASS 1 pre-operational",
        "FAIL 1 pre-operational",
        "PASS 2 operational",
        "FAIL 1.5 none came",
        "PASS 2.5 initialising",
        "PASS 2 initialising",
    ]
