import pytest

from canopen_twins.bench.bench import Bench
from canopen_twins.bus.frame import Frame
from canopen_twins.diagnosis.decoder import Decoder

WORDS = [
    ("000#0105", "NMT operational, node 5"),
    ("000#8100", "NMT reset node, all nodes"),
    ("000#5500", "NMT command 55h, all nodes"),
    ("000#01", "NMT, too short"),
    ("080#", "SYNC"),
    ("085#0023032300000000", "EMCY 2300h register 03h"),
    ("085#0000000000000000", "EMCY 0000h register 00h no error left"),
    ("085#0000050133000000", "EMCY 0000h register 05h one error less"),
    ("185#R", "TPDO1 requested"),
    (
        "185#D007D007E2040300",
        "TPDO1 Actual voltage = 2000, Actual current = 2000, Actual power = 1250,"
        " State of output = 3",
    ),
    ("205#3C05", "RPDO1 Voltage reference = 1340"),
    ("605#4014200000000000", "SDO read 0x2014:00 Run command"),
    ("605#2B14200001000000", "SDO write 0x2014:00 Run command = 1"),
    ("605#2214200001000000", "SDO write 0x2014:00 Run command = 1"),
    ("605#2F14200001000000", "SDO write 0x2014:00 Run command = 01"),
    ("605#4099990000000000", "SDO read 0x9999:00"),
    ("605#6000000000000000", "SDO read segment"),
    ("605#A008100000000000", "SDO block transfer"),
    ("605#40", "SDO request, too short"),
    ("585#6014200000000000", "SDO written 0x2014:00 Run command"),
    ("585#4B10200018FC0000", "SDO answer 0x2010:00 Voltage reference = -1000"),
    ("585#410810000D000000", "SDO answer 0x1008:00 Manufacturer Device Name in segments"),
    (
        "585#8018100102000106",
        "SDO abort 0x1018:01 Identity Object.Vendor ID, 06010002h"
        " Attempt to write a read only object",
    ),
    (
        "605#8010200000000405",
        "SDO abort by the client, 05040000h Timeout of transfer communication detected",
    ),
    ("585#8201020304050607", "SDO segment"),
    ("585#80", "SDO answer, too short"),
    ("605#8201020304050607", "SDO block transfer"),
    ("705#00", "boot-up"),
    ("705#05", "heartbeat operational"),
    ("707#7F", "heartbeat pre-operational"),
    ("707#FF", "heartbeat pre-operational"),
    ("608#4014200000000000", "SDO read 0x2014:00"),
    ("00000605#4014200000000000", ""),
    ("6F5#00", ""),
]


@pytest.mark.parametrize(("frame", "words"), WORDS)
def test_a_frame_is_told_in_words(frame, words):
    bench = Bench("topcon", node_id=5)
    assert Decoder([bench.twin.node]).words(Frame.parse(frame)) == words


def test_an_error_has_its_label_even_after_it_is_gone():
    bench = Bench("topcon", node_id=5)
    bench.inject("error", number=0x23)
    decoder = Decoder([bench.twin.node])
    told = decoder.words(bench.trace[-1].frame)
    assert told == "EMCY 2300h register 03h gate driver A fault"
    bench.sdo["Run command"].raw = 2
    assert decoder.words(Frame.parse("085#0023032300000000")) == told


def test_a_node_that_is_off_is_told_without_names():
    bench = Bench("topcon", node_id=5)
    bench.power_off()
    words = Decoder([bench.twin.node]).words(Frame.parse("605#4014200000000000"))
    assert words == "SDO read 0x2014:00"
