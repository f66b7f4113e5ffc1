"""The scenario's own master: it reads and writes by SDO, however long an answer takes."""

from io import StringIO

import pytest

from canopen_twins.scenario import play
from canopen_twins.scenario.sdo_client import Answer, download, upload
from canopen_twins.slave.object import Abort

TEXT = "a text in several segments"


def talk(transfer, *answers):
    """What comes of a transfer, and what the client has asked."""
    asked = [next(transfer).hex()]
    try:
        for answer in answers:
            asked.append(transfer.send(bytes.fromhex(answer)).hex())
    except StopIteration as end:
        return end.value, asked
    return None, asked


def test_long_values_are_written_and_read_in_segments(played):
    frames, outcomes = played(
        f"- {{at: 1, write: {{Text: {TEXT}}}}}\n- {{at: 2, read: {{Text: {TEXT}}}}}\n"
    )
    assert outcomes == [f"PASS 2 Text is {TEXT!r}"]
    assert [frame for frame in frames if frame.startswith("1 605#")] == [
        "1 605#210520001A000000",
        "1 605#0061207465787420",
        "1 605#10696E2073657665",
        "1 605#0072616C20736567",
        "1 605#156D656E74730000",
    ]
    assert [frame[:8] for frame in frames if frame.startswith("2 605#")] == [
        "2 605#40",
        "2 605#60",
        "2 605#70",
        "2 605#60",
        "2 605#70",
    ]


@pytest.mark.parametrize(
    ("read", "outcome"),
    [
        ("{Word: 0x1234}", "PASS 1 Word is 0x1234"),
        ("{Word: 0x1235}", "FAIL 1 Word is 0x1234"),
        ("{Word: any}", "PASS 1 Word is 4660"),
        (
            "{Three bytes: {min: -3, max: -1}, Text: text}",
            "PASS 1 Three bytes is -2, Text is 'text'",
        ),
        ("{Text: test, Word: 1}", "FAIL 1 Text is 'text'"),
        ("{Truth: 1}", "PASS 1 Truth is True"),
        ("{Domain: any}", "PASS 1 Domain is b''"),
        ("{Refusing: any}", "ERROR 1 Refusing is refused with 0x08000021 (local control)"),
        ("{Refusing: any}, abort: 0x08000021", "PASS 1 Refusing is refused with 0x08000021"),
        ("{Word: any}, abort: 0x08000021", "FAIL 1 Word is accepted"),
        ("{Word: any}, abort: none", "FAIL 1 Word is accepted"),
        ("{0x2F00: any}, abort: 0x06020000", "PASS 1 0x2F00 is refused with 0x06020000"),
    ],
)
def test_what_is_read_is_judged(played, read, outcome):
    _, (found,) = played(f"- {{at: 1, read: {read}}}\n")
    assert found.startswith(outcome)


def test_no_answer_may_be_what_is_expected(played):
    _, outcomes = played(
        """\
        - {at: 1, nmt: stop}
        - {at: 2, read: {Word: any}, abort: none, timeout: 0.3}
        - {at: 2, write: {Byte: 1}, abort: none, timeout: 0.2}
        """
    )
    assert outcomes == ["PASS 2.3 Word is not answered", "PASS 2.5 Byte is not answered"]


def test_an_answer_within_the_time_is_waited_for(played):
    steps = """\
        - {{at: 1, inject: {{sdo_late: {{seconds: {late}}}}}}}
        - {{at: 2, write: {{Byte: 1, Word: 2}}, timeout: 0.5}}
        - {{after: 1, send: 111#}}
        """
    frames, outcomes = played(steps.format(late=0.2))
    assert [frame for frame in frames if float(frame.split()[0]) >= 2] == [
        "2 605#2F00200001000000",
        "2.2 585#6000200000000000",
        "2.2 605#2B01200002000000",
        "2.4 585#6001200000000000",
        "3.4 111#",
    ]
    assert outcomes == []
    frames, outcomes = played(steps.format(late=0.6))
    assert outcomes == [
        "ERROR 2.5 Byte is not answered",
        "SKIP 2.5 left out after the error in line 5",
    ]


def test_a_late_answer_is_none_to_the_next_request(played):
    frames, outcomes = played(
        """\
        - {at: 1, inject: {sdo_late: {seconds: 0.3}}}
        - {at: 2, read: {Word: any}, timeout: 0.2, abort: none}
        - {at: 2.25, read: {Byte: 0}}
        """
    )
    assert outcomes == ["PASS 2.2 Word is not answered", "PASS 2.55 Byte is 0"]
    assert "2.3 585#4B01200034120000" in frames


def test_two_steps_ask_one_node_one_after_the_other(played):
    frames, outcomes = played(
        """\
        - {at: 1, inject: {sdo_late: {seconds: 0.2}}}
        - {at: 2, write: {Byte: 1}}
        - {at: 2.1, write: {Byte: 2}}
        - {at: 2.15, read: {Byte: 2}}
        """
    )
    asked = [frame for frame in frames if "605#" in frame]
    assert [frame.split()[0] for frame in asked] == ["2", "2.2", "2.4"]
    assert outcomes == ["PASS 2.6 Byte is 2"]


@pytest.mark.parametrize(
    "fault", ["sdo_wrong_toggle: {segment: 2}", "sdo_wrong_toggle: {segment: 1}"]
)
def test_what_is_no_answer_makes_the_client_abort(played, fault):
    frames, outcomes = played(
        f"- {{at: 1, inject: {{{fault}}}}}\n- {{at: 2, write: {{Text: {TEXT}}}}}\n"
    )
    assert outcomes == ["ERROR 2 Text is answered with what is no answer to the request"]
    assert frames[-1] == "2 605#8005200000000305"


def test_on_a_bus_with_a_bit_rate_every_frame_takes_its_time(loaded):
    scenario = loaded(
        f"""\
        version: 1
        node: {{device: probe, node_id: 5}}
        bit_rate: 10000
        steps:
          - {{at: 1, write: {{Byte: 1, Text: {TEXT}}}}}
          - {{after: 0, read: {{Text: {TEXT}}}}}
          - {{after: 0.01, expect: {{silence: true, within: 0.1}}}}
        """
    )
    trace = StringIO()
    verdict = play(scenario, trace)
    assert verdict.ok, verdict
    times = [float(line[1:18]) for line in trace.getvalue().splitlines()]
    assert times == sorted(set(times))
    assert len(times) == 1 + 2 + 10 + 10
    assert 1.2 < verdict.outcomes[0].time < 1.4


def test_a_transfer_ends_with_what_the_server_says():
    address = (0x2005, 0)
    refused = "8005200002000106"
    assert talk(download(address, b"1"), refused)[0] == Answer(Abort.READ_ONLY)
    assert talk(download(address, b"12345"), refused)[0] == Answer(Abort.READ_ONLY)
    assert talk(upload(address), refused)[0] == Answer(Abort.READ_ONLY)
    assert talk(upload(address), "4105200008000000", refused)[0] == Answer(Abort.READ_ONLY)
    wrong = Answer(Abort.COMMAND, by_client=True)
    assert talk(upload(address), "6005200000000000")[0] == wrong
    assert talk(download(address, b"1"), "4305200000000000")[0] == wrong


def test_what_is_read_is_as_long_as_the_server_says():
    address = (0x2005, 0)
    assert talk(upload(address), "4F05200061626364")[0] == Answer(0, b"a")
    assert talk(upload(address), "4205200061626364")[0] == Answer(0, b"abcd")
    segments = ["4105200009000000", "0061626364656667", "1B68690000000000"]
    answer, asked = talk(upload(address), *segments)
    assert answer == Answer(0, b"abcdefghi")
    assert asked == ["4005200000000000", "6000000000000000", "7000000000000000"]


def test_how_many_bytes_count_may_be_left_to_the_object():
    assert talk(download((0x2F00, 7), b"\1\2\3\4", sized=False))[1] == ["22002f0701020304"]


def test_two_nodes_are_asked_at_the_same_time(loaded, judged):
    scenario = loaded(
        """\
        version: 1
        nodes: {left: {device: probe, node_id: 5}, right: {device: probe, node_id: 6}}
        steps:
          - {at: 0, node: left, inject: {sdo_late: {seconds: 0.5}}}
          - {at: 0, node: right, inject: {sdo_late: {seconds: 0.25}}}
          - {at: 1, node: left, read: {Byte: 0}}
          - {at: 1, node: right, read: {Byte: 0}}
          - {at: 1.1, node: right, read: {Word: any}}
        """
    )
    assert judged(scenario) == [
        "PASS 1.5 Byte is 0",
        "PASS 1.25 Byte is 0",
        "PASS 1.5 Word is 4660",
    ]
