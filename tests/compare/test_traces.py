import gzip

import can
import pytest

from canopen_twins.bus.frame import Frame
from canopen_twins.errors import UserError
from canopen_twins.record.trace_formats import columns
from canopen_twins.record.trace_reader import Trace

FRAMES = [
    (0, "705#00"),
    (1_500, "605#4018100100000000"),
    (2_250, "705#R"),
    (1_000_000, "18FEF105#0102030405060708"),
    (1_000_001, "080#"),
]
"""Microseconds from the first on."""

LOG_L = """\
(1436509052.000000) can0 705#00
(1436509052.001500) can0 605#4018100100000000 R
(1436509052.002000) can0 20000080#0000000000000000
(1436509052.002100) can0 123##1112233
(1436509052.002250) can0 705#R T
(1436509053.000000) can0 18FEF105#0102030405060708
(1436509053.000001) can0 080#
"""
SHOWN = """\
 ({0})  can0  705   [1]  00
 ({1})  can0  605   [8]  40 18 10 01 00 00 00 00   '@.......'
 ({2})  can0  20000080   [8]  00 00 00 00 00 00 00 00   ERRORFRAME
 ({3})  can0  705   [0]  remote request
 ({4})  can0  18FEF105   [8]  01 02 03 04 05 06 07 08
 ({5})  can0  080   [0]
"""
ASC = """\
date Fri Jul 10 08:17:32.000 am 2015
base hex  timestamps {mode}
internal events logged
// version 9.0.0
{begin}   {0} 1  705             Rx   d 1 00  Length = 98 BitCount = 51 ID = 1797
   {1} 1  605             Tx   d 8 40 18 10 01 00 00 00 00
   {2} 1  ErrorFrame
   {3} 1  705             Rx   r
   {4} 1  18FEF105x       Rx   d 8 01 02 03 04 05 06 07 08
   {5} CANFD   1 Rx         80                                   0 0 0  0      0    0   0  0
{end}"""
BEGIN = "Begin Triggerblock Fri Jul 10 08:17:32.000 am 2015\n   0.000000 Start of measurement\n"
END = "End TriggerBlock\n"
TRC = {
    "1.0": """\
;##########
     1)      5  0705  1  00
     2)      6.5  0605  8  40 18 10 01 00 00 00 00
     3)      7  FFFFFFFF  4  00 00 00 08
     4)      7.25  0705  0  RTR
     5)   1005  18FEF105  8  01 02 03 04 05 06 07 08
     6)   1005.001  0080  0
""",
    "1.1": """\
;$FILEVERSION=1.1
;$STARTTIME=42190.3455092593
     1)         5.0  Rx         0705  1  00
     2)         6.5  Tx         0605  8  40 18 10 01 00 00 00 00
     3)         7.0  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY
     4)         7.25  Rx         0705  0  RTR
     5)      1005.0  Rx     18FEF105  8  01 02 03 04 05 06 07 08
     6)      1005.001  Rx         0080  0
""",
    "1.3": """\
;$FILEVERSION=1.3
     1)         5.0 1  Rx        0705 -  1    00
     2)         6.5 1  Tx        0605 -  8    40 18 10 01 00 00 00 00
     3)         7.25 1  Rx        0705 -  0    RTR
     4)      1005.0 1  Rx    18FEF105 -  8    01 02 03 04 05 06 07 08
     5)      1005.001 1  Rx        0080 -  0
""",
    "2.1": """\
;$FILEVERSION=2.1
;$COLUMNS=N,O,T,B,I,d,R,L,D
      1         5.000 DT 1      0705 Rx -  1    00
      2         6.500 DT 1      0605 Tx -  8    40 18 10 01 00 00 00 00
      3         7.000 ST 1         - Rx -  4    00 00 00 08
      4         7.250 RR 1      0705 Rx -  0
      5      1005.000 DT 1  18FEF105 Rx -  8    01 02 03 04 05 06 07 08
      6      1005.001 DT 1      0080 Rx -  0
""",
}


def dates(microseconds):
    return f"2015-07-10 08:17:{32 + microseconds // 1_000_000:02}.{microseconds % 1_000_000:06}"


def seconds(microseconds):
    return f"{microseconds // 1_000_000:03}.{microseconds % 1_000_000:06}"


TICKS = (0, 1_500, 2_000, 2_250, 1_000_000, 1_000_001)
STEPS = (0, 1_500, 500, 250, 997_750, 1)


def read(path, *options):
    trace = Trace(path, *options)
    frames = list(trace)
    first = frames[0].tick
    return [(sent.tick - first, str(sent.frame)) for sent in frames], trace.remarks


def written(tmp_path, name, text):
    path = tmp_path / name
    path.write_text(text, "utf-8")
    return path


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("candump.log", LOG_L),
        ("absolute.txt", SHOWN.format(*(f"14365090{52 + t / 1e6:.6f}" for t in TICKS))),
        ("dates.txt", SHOWN.format(*map(dates, TICKS))),
        ("zero.log", SHOWN.format(*map(seconds, TICKS))),
        ("differences.log", SHOWN.format(*map(seconds, STEPS))),
        ("rx.log", SHOWN.format(*map(seconds, TICKS)).replace("can0  ", "can0  RX - -  ")),
        ("block.asc", ASC.format(*map(seconds, TICKS), mode="absolute", begin=BEGIN, end=END)),
        ("plain.asc", ASC.format(*map(seconds, TICKS), mode="absolute", begin="", end="")),
        ("steps.asc", ASC.format(*map(seconds, STEPS), mode="relative", begin="", end="")),
        ("steps.asc", ASC.format(*map(seconds, STEPS), mode="relative", begin=BEGIN, end=END)),
        *((f"v{version}.trc", text) for version, text in TRC.items()),
    ],
)
def test_a_trace_is_read_whoever_wrote_it(tmp_path, name, text):
    frames, remarks = read(written(tmp_path, name, text))
    assert (frames, remarks) == (FRAMES, [])


def test_identifiers_and_data_of_an_asc_may_be_decimal(tmp_path):
    text = "base dec  timestamps absolute\n 0.1 1 1541 Rx d 2 64 255\n"
    assert read(written(tmp_path, "dec.asc", text)) == ([(0, "605#40FF")], [])


def test_a_blf_is_read(tmp_path):
    path = tmp_path / "out.blf"
    with can.BLFWriter(path) as writer:
        for tick, text in FRAMES:
            frame = Frame.parse(text)
            writer.on_message_received(
                can.Message(
                    timestamp=1.4e9 + tick / 1e6,
                    arbitration_id=frame.can_id,
                    is_extended_id=frame.extended,
                    is_remote_frame=frame.remote,
                    data=frame.data,
                    channel=0,
                )
            )
    assert read(path) == (FRAMES, [])


SAVVY = """\
Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8
5000000,00000705,false,Rx,0,1,00,,,,,,,
5001500,00000605,false,Tx,0,8,40,18,10,01,00,00,00,00
6000000,18FEF105,true,Rx,0,8,01,02,03,04,05,06,07,08
"""
SEMICOLONS = """\
# Logger type: CL2000
Timestamp;Type;ID;Data
5.0;0;705;00
5.0015;8;605;4018100100000000
6.0;1;18fef105;0102030405060708
"""
NUMBERS = """\
ms\tid\tdata
5000\t0x705\t0x00
5001.5\t0x605\t40 18 10 01 00 00 00 00
6000\t18FEF105h\t0102030405060708
"""


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (SAVVY, "us=Time Stamp,id=ID,data=D1-D8,length=LEN,extended=Extended"),
        (SEMICOLONS, "time=Timestamp,id=ID,data=Data"),
        (NUMBERS, "ms=1,id=2,data=3"),
    ],
)
def test_the_columns_of_a_csv_are_named(tmp_path, text, named):
    frames, remarks = read(written(tmp_path, "out.csv", text), None, columns(named))
    assert (frames, remarks) == ([FRAMES[0], FRAMES[1], FRAMES[3]], [])


def test_a_csv_of_python_can_needs_no_names(tmp_path):
    path = tmp_path / "out.csv"
    with can.CSVWriter(path) as writer:
        writer.on_message_received(
            can.Message(timestamp=1.5, arbitration_id=0x705, is_extended_id=False, data=[5])
        )
    assert read(path) == ([(0, "705#05")], [])


@pytest.mark.parametrize(
    ("name", "text", "damaged"),
    [
        ("out.log", LOG_L, "(1436509052.1) can0 705#0"),
        ("out.log", LOG_L, "(14365090"),
        ("out.log", LOG_L, "\x00\x00\x00"),
        ("out.log", LOG_L, "(1436509052.1) can0 FFF#00"),
        ("out.txt", SHOWN.format(*map(dates, TICKS)), " (2015-07-10)  can0  705   [2]  00"),
        ("out.asc", ASC.format(*TICKS, mode="absolute", begin="", end=""), " 0.1 1 705 Rx d 8 00"),
        ("out.trc", TRC["1.1"], " 7)  1006.0  Rx  0705  8  00"),
        ("out.trc", TRC["2.1"], " 7  1006.0  DT 1"),
    ],
)
def test_a_damaged_line_is_told_and_left_out(tmp_path, name, text, damaged):
    text = text.replace("0 1  ", "0.0 1  ") if name == "out.asc" else text
    lines = text.splitlines()
    path = written(tmp_path, name, "\n".join([*lines, damaged, ""]))
    count = len(list(Trace(written(tmp_path, f"whole{path.suffix}", text))))
    trace = Trace(path)
    assert len(list(trace)) == count > 0
    (remark,) = trace.remarks
    assert remark.startswith(f"{path}:{len(lines) + 1}: left out, ")


def test_of_many_damaged_lines_the_first_are_told(tmp_path):
    path = written(tmp_path, "out.log", LOG_L + "x\n" * 20)
    _, remarks = read(path)
    assert len(remarks) == 6
    assert remarks[-1] == f"{path}: 15 more lines are damaged"


def test_a_packed_trace_is_read(tmp_path):
    path = tmp_path / "out.asc.gz"
    text = ASC.format(*map(seconds, TICKS), mode="absolute", begin="", end="")
    path.write_bytes(gzip.compress(text.encode()))
    assert read(path) == (FRAMES, [])


TWO = "(1.0) can0 705#00\n(1.1) can1 706#00\n(1.2) can0 705#05\n"


def test_one_of_two_channels_is_named(tmp_path):
    path = written(tmp_path, "two.log", TWO)
    assert read(path, "can1") == ([(0, "706#00")], [])
    with pytest.raises(UserError, match="it has the channels can0 and can1: say which with --chan"):
        list(Trace(path))
    with pytest.raises(UserError, match="has no channel can2"):
        list(Trace(path, "can2"))


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("out.log", "  can0  705   [1]  00\n", "its lines have no times: candump needs -l, -L or"),
        ("out.pcap", "", "is no trace file: its name ends in .asc, .blf, .csv, .log"),
        (
            "out.csv",
            "Time,ID,Data\n0.1,705,00\n",
            "out.csv: not the columns of python-can: name them",
        ),
        ("out.trc", ";$FILEVERSION=3.0\n", "its version 3.0 is none of 1.0 to 1.3, 2.0 and 2.1"),
        ("out.blf", "LOGG", "cannot be read as .blf: "),
    ],
)
def test_what_is_of_no_use_is_told_in_a_line(tmp_path, name, text, told):
    with pytest.raises(UserError) as refusal:
        list(Trace(written(tmp_path, name, text)))
    assert told in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("time", "--columns time: write it as time=NAME,id=NAME,data=NAME"),
        ("tim=1,id=2,data=3", "did you mean 'time'"),
        ("id=2,data=3", "--columns does not say where time is"),
        ("time=1", "--columns does not say where id, data is"),
    ],
)
def test_nonsense_in_columns_is_told(text, told):
    with pytest.raises(UserError) as refusal:
        columns(text)
    assert told in str(refusal.value)


def test_columns_that_are_not_there_are_told(tmp_path):
    path = written(tmp_path, "out.csv", SAVVY)
    with pytest.raises(UserError, match="no line has the columns Time, ID, D1"):
        list(Trace(path, None, columns("us=Time,id=ID,data=D1")))
