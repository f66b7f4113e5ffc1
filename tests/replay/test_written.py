"""Everything by which a master writes counts, whatever the node makes of it."""

from binascii import crc_hqx

import pytest
from hypothesis import given
from hypothesis import strategies as st
from probe import Probe

from canopen_twins import Bench
from canopen_twins.scenario import Player
from canopen_twins.scenario.bus_events import Downloaded, Downloads


@pytest.mark.parametrize(
    ("frame", "wanted", "kind"),
    [
        ("605#2F00200001000000", "Byte: 1", "PASS"),
        ("605#2F00200001000000", "Byte: 2", "FAIL"),
        ("605#2F00200001000000", "0x2000: {max: 1}", "PASS"),
        ("605#2200200001FFFFFF", "Byte: 1", "PASS"),
        ("605#2300200001000000", "Byte: 1", "PASS"),
        ("605#2300200001010000", "Byte: 1", "FAIL"),
        ("605#270B2000FFFFFF00", "Three bytes: -1", "PASS"),
        ("605#230420000000003F", "Real: 0.5", "PASS"),
        ("605#2F04200001000000", "Real: any", "PASS"),
        ("605#2705200061626300", "Text: abc", "PASS"),
        ("605#2F0320007F000000", "Limited: 127", "PASS"),
        ("605#2F09200001000000", "Read only: 1", "PASS"),
        ("605#2F002F0001000000", "0x2F00: 1", "PASS"),
        ("605#2F002000010000", "Byte: any", "FAIL"),
        ("606#2F00200001000000", "Byte: any", "FAIL"),
        ("605#4000200000000000", "Byte: any", "FAIL"),
        ("205#010203", "Byte: 1, Word: 0x0302", "PASS"),
        ("205#0102", "Byte: 1", "PASS"),
        ("205#0102", "Word: any", "FAIL"),
        ("305#01000000", "Double word: 1", "PASS"),
        ("405#01", "Byte: any", "FAIL"),
        ("205#R", "Byte: any", "FAIL"),
        ("00000205#010203", "Byte: any", "FAIL"),
    ],
)
@pytest.mark.parametrize("command", ["start", "stop", "pre-operational"])
def test_requests_and_pdos_write_in_every_state(played, command, frame, wanted, kind):
    _, (outcome,) = played(
        f"""\
        - {{at: 1, nmt: {command}}}
        - {{at: 2, expect: {{write: {{{wanted}}}, within: 1}}}}
        - {{at: 2.5, send: {frame}}}
        """
    )
    assert outcome.startswith(kind)


def test_requests_write_even_to_a_node_without_power(played):
    _, outcomes = played(
        """\
        - {at: 1, power: off}
        - {at: 2, send: 605#2F00200001000000}
        - {at: 2, expect: {write: {Byte: 1}, within: 0}}
        - {at: 3, send: 205#010203}
        - {at: 3, expect: {never: {write: {Byte: 1}}, within: 0}}
        """
    )
    assert outcomes == ["PASS 2 Byte = 1", "PASS 3 none came"]


def test_a_pdo_writes_what_is_mapped_at_that_moment(played):
    _, outcomes = played(
        """\
        - {at: 1, write: {RPDO 1.COB-ID: 0x80000205, RPDO 1 mapping.Number of mapped objects: 0}}
        - {at: 1, write: {RPDO 1 mapping.Mapped object 1: 0x20010010}}
        - {at: 1, write: {RPDO 1 mapping.Number of mapped objects: 1, RPDO 1.COB-ID: 0x211}}
        - {at: 2, send: 205#0102}
        - {at: 2, send: 211#0304}
        - {at: 2, expect: {write: {Word: 0x0403}, within: 0}}
        - {at: 3, nmt: reset-communication}
        - {at: 4, send: 205#0a0b0c}
        - {at: 4, expect: {write: {Byte: 10, Word: 0x0c0b}, within: 0}}
        """
    )
    assert outcomes == ["PASS 2 Word = 0x0403", "PASS 4 Byte = 10, Word = 0x0c0b"]


def test_a_segmented_write_counts_when_it_is_complete(played):
    frames, outcomes = played(
        """\
        - {at: 1, write: {Text: a text in several segments}}
        - {at: 1, expect: {write: {Text: a text in several segments}, within: 0}}
        - {at: 2, send: 605#2105200008000000}
        - {at: 2, send: 605#0061626364656667}
        - {at: 2, expect: {never: {write: {Text: any}}, within: 0.5}}
        - {at: 3, send: 605#1D68000000000000}
        - {at: 3, expect: {write: {Text: abcdefgh}, within: 0}}
        """
    )
    assert outcomes == [
        "PASS 1 Text = 'a text in several segments'",
        "PASS 2.5 none came",
        "PASS 3 Text = 'abcdefgh'",
    ]
    assert "1 605#210520001A000000" in frames


def asked(requests, answers=()):
    """What a client has written with requests; after some of them the server has answered."""
    downloads, written = Downloads(), []
    for number, request in enumerate(requests):
        written += downloads.ask(bytes.fromhex(request))
        if number in dict(answers):
            downloads.answer(bytes.fromhex(dict(answers)[number]))
    return written


INITIATE, OPENED = "C2052000 0A000000", "A4052000 7F000000"
FIRST, SECOND, LAST = "01 61626364656667", "02 68696A6B6C6D6E", "82 68696A00000000"
END = f"D1 {crc_hqx(b'abcdefghij', 0).to_bytes(2, 'little').hex()} 0000000000"
TEXT = [Downloaded((0x2005, 0), b"abcdefghij")]


def test_a_block_write_counts_at_its_end():
    requests = [INITIATE, FIRST, LAST, END]
    answers = [(0, OPENED), (2, "A2027F 0000000000")]
    assert asked(requests, answers) == TEXT
    assert asked(requests[:-1], answers) == []


def test_what_the_server_has_not_confirmed_comes_again():
    requests = [INITIATE, FIRST, LAST, "81 68696A00000000", END]
    assert (
        asked(requests, [(0, OPENED), (2, "A2017F 0000000000"), (3, "A2017F 0000000000")]) == TEXT
    )


@pytest.mark.parametrize("answers", [(), [(0, "80052000 02000106")]])
def test_a_block_write_that_is_not_let_in_is_none_and_the_next_request_counts(answers):
    expedited = "2F002000 01000000"
    assert asked([INITIATE, expedited], answers) == [Downloaded((0x2000, 0), b"\x01")]


def test_who_aborts_has_not_written():
    abort = "80052000 00000405"
    assert asked(["21052000 08000000", "00 61626364656667", abort, "1D 68000000000000"]) == []
    requests = [INITIATE, FIRST, abort, LAST, END]
    assert asked(requests, [(0, OPENED)]) == []


def test_a_segment_that_is_repeated_counts_once():
    segment = "00 61626364656667"
    requests = ["21052000 08000000", segment, segment, "1D 68000000000000"]
    assert asked(requests) == [Downloaded((0x2005, 0), b"abcdefgh")]


@pytest.mark.parametrize("block", [False, True])
def test_what_a_real_master_writes_counts_whatever_the_transfer(story, block):
    text = "a text that takes a good many segments, and then some more of them"
    scenario = story(
        f"- {{at: 0, expect: {{write: {{Text: '{text}'}}, within: 1}}}}\n"
        "- {at: 0, expect: {write: {Byte: 7, Word: 8}, within: 1}}\n"
    )
    bench = Bench.of({"probe": Probe(block=True)})
    player = Player(scenario, bench.segment, {"probe": bench["probe"].node})
    player.start()
    bench.run(0.5)
    with bench.sdo[0x2005].open(
        "wb", size=len(text), block_transfer=block, buffering=1024
    ) as stream:
        stream.write(text.encode())
    remote = bench["probe"].remote
    remote.rpdo.read()
    remote.rpdo[1]["Byte"].raw, remote.rpdo[1]["Word"].raw = 7, 8
    remote.rpdo[1].transmit()
    assert player.done
    assert [each.seen for each in player.verdict.outcomes] == [
        f"Text = {text!r}",
        "Byte = 7, Word = 8",
    ]


FRAMES = st.binary(min_size=8, max_size=8)


@given(st.lists(st.tuples(st.booleans(), FRAMES), max_size=40))
def test_whatever_is_on_the_bus_is_followed(frames):
    downloads, initiated = Downloads(), 0
    for by_client, data in frames:
        if by_client:
            initiated += data[0] >> 5 in (1, 6)
            written = list(downloads.ask(data))
            assert len(written) <= 1
            initiated -= len(written)
        else:
            downloads.answer(data)
    assert initiated >= 0
