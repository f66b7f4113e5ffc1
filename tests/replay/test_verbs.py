import pytest

from canopen_twins.scenario import play


def test_objects_are_written_one_after_the_other_by_sdo(played):
    frames, outcomes = played(
        """\
        - {at: 0.5, write: {Byte: 1, 0x2001: 0x0203, Three bytes: -1, With a gap.First: 4}}
        - {at: 1, write: {Double word: 5, Real: 0.5, Truth: true, Text: abc}}
        """
    )
    assert outcomes == []
    assert [frame for frame in frames if " 605#" in frame] == [
        "0.5 605#2F00200001000000",
        "0.5 605#2B01200003020000",
        "0.5 605#270B2000FFFFFF00",
        "0.5 605#2F0D200104000000",
        "1 605#2302200005000000",
        "1 605#230420000000003F",
        "1 605#2F0C200001000000",
        "1 605#2705200061626300",
    ]


@pytest.mark.parametrize(
    ("written", "abort", "outcome"),
    [
        ("Limited: 101", "0x06090031", "PASS 1 Limited is refused with 0x06090031 (too high)"),
        ("Limited: 101", "0x06090032", "FAIL 1 Limited is refused with 0x06090031 (too high)"),
        ("Limited: 100", "0x06090031", "FAIL 1 Limited is accepted"),
        ("Read only: 1", "0x06010002", "PASS 1 Read only is refused with 0x06010002 (read only)"),
        ("0x2F00: 1", "0x06020000", "PASS 1 0x2F00 is refused with 0x06020000 (no object)"),
        ("0x2001:07: 1", "0x06090011", "PASS 1 0x2001:07 is refused with 0x06090011 (no subindex)"),
    ],
)
def test_a_master_that_shall_be_refused_is(played, written, abort, outcome):
    _, outcomes = played(f"- {{at: 1, write: {{{written}}}, abort: {abort}}}\n")
    assert outcomes == [outcome]


def test_a_write_that_is_refused_unexpectedly_is_an_error_and_ends_its_step(played):
    frames, outcomes = played("- {at: 1, write: {Byte: 1, Refusing: 1, Word: 1}}\n")
    assert outcomes == ["ERROR 1 Refusing is refused with 0x08000021 (local control)"]
    assert len([frame for frame in frames if " 605#" in frame]) == 2


def test_a_write_without_answer_is_no_refusal(played):
    _, outcomes = played(
        """\
        - {at: 1, nmt: stop}
        - {at: 3, write: {Limited: 101}, abort: 0x06090031}
        """
    )
    assert outcomes == ["FAIL 4 Limited is not answered"]


def test_a_write_without_answer_in_time_is_an_error(played):
    frames, outcomes = played("- {at: 1, nmt: stop}\n- {at: 2, write: {Byte: 1, Word: 2}}\n")
    assert outcomes == ["ERROR 3 Byte is not answered"]
    assert frames[-1] == "3 605#8000200000000405"


@pytest.mark.parametrize(
    ("command", "frames"),
    [
        ("start", ["1 000#0105", "1 185#000000"]),
        ("stop", ["1 000#0205"]),
        ("pre-operational", ["1 000#8005"]),
        ("reset-node", ["1 000#8105", "1 705#00"]),
        ("reset-communication", ["1 000#8205", "1 705#00"]),
    ],
)
def test_the_nmt_master_commands_the_node(played, command, frames):
    assert played(f"- {{at: 1, nmt: {command}}}\n") == (["0 705#00", *frames], [])


def test_any_frame_is_sent(played):
    frames, _ = played("- {at: 1, send: 605#40.08.20.00.00.00.00.00}\n- {at: 2, send: 185#R}\n")
    assert frames[1:] == ["1 605#4008200000000000", "1 585#4B08200008080000", "2 185#R"]


def test_power_goes_and_comes_back(played):
    frames, _ = played("- {at: 1, power: off}\n- {at: 2, power: on}\n- {at: 3, power: on}\n")
    assert frames == ["0 705#00", "2 705#00"]


def test_faults_that_every_device_has_are_injected_in_the_same_way(played):
    frames, outcomes = played(
        """\
        - {at: 1, inject: {sdo_abort: {object: Byte, code: 0x08000022, times: 1}}}
        - {at: 1, write: {Byte: 1}, abort: 0x08000022}
        - {at: 1, write: {Byte: 1}}
        - {at: 2, inject: {frame_lost: {frame: 585#*}, power_cycle: {seconds: 0.5}}}
        - {at: 3, clear: all}
        """
    )
    assert outcomes == ["PASS 1 Byte is refused with 0x08000022 (device state)"]
    assert frames[-1] == "2.5 705#00"


def test_faults_come_and_go_by_name_and_all_together(played):
    frames, _ = played(
        """\
        - {at: 1, inject: {error: {code: 0x1000}, level: {value: 3}}}
        - {at: 1, expect: {value: {Level: 3}}}
        - {at: 2, clear: error}
        - {at: 3, inject: {error: {code: 0x2000, register: 0x03}}}
        - {at: 4, clear: all}
        - {at: 5, clear: all}
        """
    )
    assert frames[1:] == [
        "1 085#0010016669656C64",
        "2 085#0000000000000000",
        "3 085#0020036669656C64",
        "4 085#0000000000000000",
    ]


def test_live_settings_change_while_the_device_runs(loaded):
    scenario = loaded(
        """\
        version: 1
        node: {device: topcon, settings: {load: resistor 4, power_on_voltage: 2000,
               power_on_current: 4000}}
        steps:
          - {at: 0, write: {Run command: 1}}
          - {at: 1, expect: {value: {Actual current: {is: 2000, tolerance: 2}}}}
          - {at: 2, set: {load: resistor 8, ambient: 40}}
          - {at: 3, expect: {value: {Actual current: {is: 1000, tolerance: 2}}}}
        """
    )
    assert play(scenario).ok


def test_a_bug_in_the_device_is_loud(story):
    with pytest.raises(KeyError, match="a bug in an object"):
        play(story("- {at: 1, write: {Faulty: 1}}\n"))
