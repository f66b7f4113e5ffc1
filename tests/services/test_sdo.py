import pytest

from canopen_twins.slave.object import Abort


def abort(multiplexer, code):
    return f"585#80{multiplexer}{code.to_bytes(4, 'little').hex().upper()}"


@pytest.mark.spec("T-030", "T-040")
@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        ("605#4000200000000000", "585#4F00200000000000"),  # one byte
        ("605#4001200000000000", "585#4B01200034120000"),
        ("605#400B200000000000", "585#470B2000FEFFFF00"),
        ("605#4014100000000000", "585#4314100085000000"),
        ("605#4005200000000000", "585#4305200074657874"),  # a text of four
        ("605#40082000FFFFFFFF", "585#4B08200008080000"),  # reserved bytes mean nothing
        ("605#5F01200000000000", "585#4B01200034120000"),  # nor do reserved bits
    ],
)
def test_up_to_four_bytes_are_read_expedited_with_the_rest_zero(bench, request_, answer):
    assert bench.send(request_) == [answer]


@pytest.mark.spec("T-030", "T-040")
@pytest.mark.parametrize(
    ("request_", "read"),
    [
        ("605#2F002000AB000000", "4F002000AB000000"),
        ("605#2B012000CDAB0000", "4B012000CDAB0000"),
        ("605#270B200001020300", "470B200001020300"),
        ("605#2302200004030201", "4302200004030201"),
        ("605#2B0520004142FFFF", "4B05200041420000"),  # what is unused is not looked at
        ("605#27062000FF00FF00", "47062000FF00FF00"),
    ],
)
def test_up_to_four_bytes_are_written_expedited(bench, request_, read):
    multiplexer = request_[6:12]
    assert bench.send(request_) == [f"585#60{multiplexer}00000000"]
    assert bench.send(f"605#40{multiplexer}00000000") == [f"585#{read}"]


@pytest.mark.spec("T-030")
@pytest.mark.parametrize(
    ("multiplexer", "read"),
    [
        ("002000", "4F00200011000000"),
        ("012000", "4B01200011220000"),
        ("0B2000", "470B200011223300"),
        ("022000", "4302200011223344"),
        ("052000", "4305200011223344"),
    ],
)
def test_a_write_without_size_takes_as_many_bytes_as_the_object_has(bench, multiplexer, read):
    assert bench.send(f"605#22{multiplexer}11223344") == [f"585#60{multiplexer}00000000"]
    assert bench.send(f"605#40{multiplexer}00000000") == [f"585#{read}"]


@pytest.mark.spec("T-034")
@pytest.mark.parametrize("command", ["40", "2F", "21"])
@pytest.mark.parametrize(
    ("multiplexer", "code"),
    [
        ("FF2F00", Abort.NO_OBJECT),
        ("050000", Abort.NO_OBJECT),
        ("FFFFFF", Abort.NO_OBJECT),
        ("002001", Abort.NO_SUBINDEX),
        ("171001", Abort.NO_SUBINDEX),
        ("001001", Abort.NO_SUBINDEX),  # known before read only
        ("0D2002", Abort.NO_SUBINDEX),
        ("0310FF", Abort.NO_SUBINDEX),
    ],
)
def test_what_is_not_there_is_refused(bench, command, multiplexer, code):
    assert bench.send(f"605#{command}{multiplexer}01000000") == [abort(multiplexer, code)]


@pytest.mark.spec("T-034")
@pytest.mark.parametrize(
    ("request_", "code"),
    [
        ("2B09200001000000", Abort.READ_ONLY),
        ("2B08200001000000", Abort.READ_ONLY),  # a constant
        ("2200100000000000", Abort.READ_ONLY),
        ("2F09200001000000", Abort.READ_ONLY),  # known before the length
        ("2109200002000000", Abort.READ_ONLY),
        ("4007200000000000", Abort.WRITE_ONLY),
    ],
)
def test_access_that_is_not_allowed_is_refused(bench, request_, code):
    assert bench.send(f"605#{request_}") == [abort(request_[2:8], code)]


def test_what_is_write_only_can_be_written(bench):
    assert bench.send("605#2B07200034120000") == ["585#6007200000000000"]
    assert bench.twin.node.slave.number(0x2007) == 0x1234


@pytest.mark.spec("T-035")
@pytest.mark.parametrize(
    ("request_", "code"),
    [
        ("2F01200001000000", Abort.TOO_SHORT),
        ("2301200001000000", Abort.TOO_LONG),
        ("2701200001000000", Abort.TOO_LONG),
        ("230A200001000000", Abort.TOO_SHORT),  # eight bytes do not fit
        ("220A200001000000", Abort.TOO_SHORT),
        ("2101200003000000", Abort.TOO_LONG),
        ("2101200001000000", Abort.TOO_SHORT),
    ],
)
def test_a_length_that_does_not_fit_is_refused_and_nothing_is_written(bench, request_, code):
    before = bench.send(f"605#40{request_[2:8]}00000000")
    assert bench.send(f"605#{request_}") == [abort(request_[2:8], code)]
    bench.send("605#8000000000000000")
    assert bench.send(f"605#40{request_[2:8]}00000000") == before


@pytest.mark.parametrize("request_", ["2F09200001000000", "2109200001000000"])
def test_the_profile_says_whether_the_length_is_looked_at_first(bench_of, request_):
    bench = bench_of(length_before_access=True)
    assert bench.send(f"605#{request_}") == [abort("092000", Abort.TOO_SHORT)]
    assert bench.send("605#2B09200001000000") == [abort("092000", Abort.READ_ONLY)]


@pytest.mark.parametrize(
    ("data", "code"),
    [("6500", Abort.TOO_HIGH), ("FF7F", Abort.TOO_HIGH), ("9BFF", Abort.TOO_LOW)],
)
def test_a_value_out_of_its_limits_is_refused_and_the_old_one_stays(bench, data, code):
    bench.send("605#2B03200007000000")
    assert bench.send(f"605#2B032000{data}0000") == [abort("032000", code)]
    assert bench.send("605#4003200000000000") == ["585#4B03200007000000"]


def test_an_object_says_itself_why_it_refuses(bench):
    refused = abort("022100", Abort.LOCAL_CONTROL)
    assert bench.send("605#4002210000000000") == [refused]
    assert bench.send("605#2F02210001000000") == [refused]


def test_an_object_acts_before_the_answer_and_news_comes_after_it(operational):
    assert operational.send("605#2B00210034120000") == ["585#6000210000000000", "185#341200"]


def test_an_adjusted_value_is_confirmed_and_read_back_adjusted(bench):
    assert bench.send("605#2F01210007000000") == ["585#6001210000000000"]
    assert bench.send("605#4001210000000000") == ["585#4F01210006000000"]


@pytest.mark.spec("T-034")
@pytest.mark.parametrize("command", ["E0", "FF", "E1", "7F", "60", "70", "00", "01", "1F", "10"])
def test_what_is_no_request_here_is_refused_without_an_object(bench, command):
    # CANopenNode and Lely agree on index 0
    assert bench.send(f"605#{command}00200011223344") == [abort("000000", Abort.COMMAND)]


@pytest.mark.parametrize("command", ["A0", "A4", "C0", "C2", "C6"])
@pytest.mark.spec("T-031")
def test_block_transfer_is_refused_with_its_object(bench, command):
    assert bench.send(f"605#{command}0120007F000000") == [abort("012000", Abort.COMMAND)]


@pytest.mark.parametrize("command", ["A1", "A2", "A3", "C1", "DD"])
def test_what_continues_a_block_transfer_names_no_object(bench, command):
    assert bench.send(f"605#{command}0120007F000000") == [abort("000000", Abort.COMMAND)]


@pytest.mark.parametrize("command", ["80", "9F"])
def test_an_abort_is_not_answered(bench, command):
    assert bench.send(f"605#{command}00200000000405") == []


@pytest.mark.parametrize("command", ["41", "5F", "30", "3F", "81", "E0", "A0", "C0", "60", "00"])
def test_the_profile_says_whether_reserved_bits_are_ignored(bench_of, command):
    bench = bench_of(literal_commands=True, segmented=False)
    assert bench.send(f"605#{command}002000AB000000") == [abort("002000", Abort.COMMAND)]


@pytest.mark.parametrize("command", ["2F", "22", "40"])
def test_literal_commands_are_known_all_the_same(bench_of, command):
    bench = bench_of(literal_commands=True, segmented=False)
    assert bench.send(f"605#{command}002000AB000000")[0][4] in "46"
    assert bench.send("605#8000200000000405") == []


@pytest.mark.parametrize(
    ("request_", "code"),
    [
        ("4008100000000000", Abort.NOT_TRANSFERABLE),  # a text of 19
        ("2105200007000000", Abort.COMMAND),
        ("2005200000000000", Abort.COMMAND),
        ("2100100008000000", Abort.COMMAND),  # read only, and too long: the command comes first
        ("2100990001000000", Abort.COMMAND),  # no such object
    ],
)
def test_without_segmented_transfer_it_is_refused_with_the_object(bench_of, request_, code):
    bench = bench_of(segmented=False)
    assert bench.send(f"605#{request_}") == [abort(request_[2:8], code)]


@pytest.mark.parametrize("command", ["00", "60"])
def test_without_segmented_transfer_a_segment_belongs_to_no_object(bench_of, command):
    bench = bench_of(segmented=False)
    assert bench.send(f"605#{command}05200000000000") == [abort("000000", Abort.COMMAND)]


@pytest.mark.spec("T-036")
@pytest.mark.parametrize(
    "frame",
    [
        "605#",
        "605#40",
        "605#40002000",
        "605#40002000000000",
        "605#2F002000AB",
        "605#80002000",
        "605#R",
        "00000605#4000200000000000",
        "606#4000200000000000",
        "600#4000200000000000",
        "585#4000200000000000",
    ],
)
def test_what_is_not_eight_bytes_on_the_one_identifier_is_not_answered(bench, frame):
    assert bench.send(frame) == []
    assert bench.send("605#4000200000000000") == ["585#4F00200000000000"]


@pytest.mark.spec("T-016", "T-037")
@pytest.mark.parametrize(
    ("command", "answered"), [("000#8005", True), ("000#0105", True), ("000#0205", False)]
)
def test_sdo_works_in_pre_operational_and_operational(bench, command, answered):
    bench.send(command)
    assert bool(bench.send("605#4000200000000000")) is answered
    assert bool(bench.send("605#2F00200001000000")) is answered
    assert bench.twin.node.slave.number(0x2000) == answered


@pytest.mark.spec("T-036")
def test_the_identifiers_are_those_of_the_dictionary_and_fixed(bench):
    assert bench.send("605#4000120100000000") == ["585#4300120105060000"]
    assert bench.send("605#4000120200000000") == ["585#4300120285050000"]
    for sub in ("01", "02"):
        assert bench.send(f"605#230012{sub}00070000") == [abort(f"0012{sub}", Abort.READ_ONLY)]
