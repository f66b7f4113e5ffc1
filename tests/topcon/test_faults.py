import csv

import pytest

from simulators import Bench, UserError
from simulators.resources import od_file

from .bus import run, state_of_output

NO_ERROR = "085#0000000000000000"
CARD_CODES = (0x5000, 0x8110, 0x8111, 0x8112, 0x8200)


def messages():
    with od_file("topcon_emcy.csv") as path, path.open(encoding="ascii", newline="") as file:
        for row in csv.DictReader(file):
            yield tuple(int(row[key], 16) for key in ("code", "register", "detail"))


def emcy(code, register, detail):
    data = code.to_bytes(2, "little") + bytes([register]) + detail.to_bytes(5, "little")
    return f"085#{data.hex().upper()}"


def inject(bench, code, detail):
    """By number, if it is an error of the unit, else by code; True for the unit (A-63)."""
    if detail or code == 0x6100:
        bench.inject("error", number=detail)
        return True
    bench.inject("card_error", code=code)
    return False


def reset(bench):
    bench.sdo["Run command"].raw = 2
    return bench.sent[-1]


@pytest.mark.spec(
    "T-056", "T-057", "T-050", "T-180", "A-12", "A-13", "A-62", "A-63", "A-65", "A-66"
)
def test_every_message_of_chapter_8_can_be_had_and_stops_the_output_if_it_is_the_unit_s(topcon):
    topcon.sdo["Voltage reference"].raw = topcon.sdo["Current reference"].raw = 2000
    told = []
    for code, register, detail in messages():
        if not code:
            continue  # the reset that ends each of the others
        topcon.sdo["Run command"].raw = 1
        of_the_unit = inject(topcon, code, detail)
        assert topcon.sent[-1] == emcy(code, register, detail)
        assert topcon.sdo["Error Register"].raw == register
        assert topcon.sdo["Pre-defined Error Field"][1].raw == detail << 16 | code
        assert state_of_output(topcon) == (0x8000 if of_the_unit else 0x0003), (code, detail)
        assert reset(topcon) == NO_ERROR
        assert state_of_output(topcon) == (0x0000 if of_the_unit else 0x0003)
        told.append((code, detail))
    assert len(told) == len(set(told)) == 516  # and the one that says it is over
    assert sum(not detail and code != 0x6100 for code, detail in told) == len(CARD_CODES)


@pytest.mark.spec("T-057", "A-62")
@pytest.mark.parametrize(
    ("fault", "parameters", "message"),
    [
        ("error", {"number": 0x14D}, "no unit error 0x14d"),
        ("error", {"number": 0x200}, "no unit error 0x200"),
        ("lasting_error", {"number": -1}, "no unit error -0x1"),
        ("card_error", {"code": 0x6100}, "no card error 0x6100"),
        ("card_error", {"code": 0x8120}, "no card error 0x8120"),
        ("mains", {"volts": 99}, "without mains the unit is off"),
        ("mains", {"volts": 601}, "100..600 V"),
        ("supply", {"rail": "12V", "volts": 12}, "unknown rail '12V'"),
        ("overtemperature", {"sensor": "fan"}, "unknown sensor 'fan'"),
        ("interlok_open", {}, "did you mean 'interlock_open'?"),
    ],
)
def test_what_chapter_8_does_not_know_cannot_be_injected(topcon, fault, parameters, message):
    with pytest.raises(UserError) as refusal:
        topcon.inject(fault, **parameters)
    assert message in str(refusal.value)
    assert topcon.sent == ["705#00"]
    assert state_of_output(topcon) == 0


CAUSES = [  # fault, its parameters, what is told: code, register, details
    ("mains", {"volts": 339}, 0x3200, 0x05, [0x4D, 0x49]),
    ("mains", {"volts": 345}, 0x3200, 0x05, []),
    ("mains", {"volts": 461}, 0x3200, 0x05, [0x4D, 0x4A]),
    ("mains", {"volts": 300}, 0x3200, 0x05, [0x4D, 0x49]),
    ("supply", {"rail": "24V", "volts": 21.5}, 0x3200, 0x05, [0x4B]),
    ("supply", {"rail": "24V", "volts": 26.5}, 0x3200, 0x05, [0x4C]),
    ("supply", {"rail": "5V", "volts": 4.4}, 0x3200, 0x05, [0x43]),
    ("supply", {"rail": "5V", "volts": 5.6}, 0x3200, 0x05, [0x44]),
    ("supply", {"rail": "15V", "volts": 13.4}, 0x3200, 0x05, [0x45]),
    ("supply", {"rail": "15V", "volts": 16.6}, 0x3200, 0x05, [0x46]),
    ("supply", {"rail": "-15V", "volts": -13.4}, 0x3200, 0x05, [0x47]),
    ("supply", {"rail": "-15V", "volts": -16.6}, 0x3200, 0x05, [0x48]),
    ("supply", {"rail": "24V", "volts": 22}, 0x3200, 0x05, []),
    ("overtemperature", {"sensor": "rectifier"}, 0x4200, 0x09, [0x50]),
    ("overtemperature", {}, 0x4200, 0x09, [0x51]),
    ("overtemperature", {"sensor": "inside"}, 0x4200, 0x09, [0x55]),
    ("interlock_open", {}, 0x9000, 0x81, [0xF2]),
    ("sense_reversed", {}, 0x3300, 0x05, [0x33]),
    ("sense_offset", {"volts": 21}, 0x3300, 0x05, [0x31]),
    ("sense_offset", {"volts": -21}, 0x3300, 0x05, [0x31]),
    ("sense_offset", {"volts": 20}, 0x3300, 0x05, []),
    ("lasting_error", {"number": 0xF4}, 0xF000, 0x81, [0xF4]),  # safety relay
    ("lasting_error", {"number": 0xF7}, 0xF000, 0x81, [0xF7]),  # enable missing
    ("lasting_error", {"number": 0xC5}, 0x7000, 0x81, [0xC5]),  # incomplete frames of a slave
    ("lasting_error", {"number": 0x65}, 0x8100, 0x11, [0x65]),  # HMI unplugged
]


@pytest.mark.spec("T-193", "T-194", "A-63", "A-83")
@pytest.mark.parametrize(("fault", "parameters", "code", "register", "details"), CAUSES)
def test_a_cause_is_told_stops_the_output_and_can_be_reset_when_it_is_gone(
    topcon, fault, parameters, code, register, details
):
    run(topcon, voltage=2000)
    topcon.run(1.0)
    topcon.inject(fault, **parameters)
    topcon.run(0.1)
    told = [frame for frame in topcon.sent if frame.startswith("085")]
    assert sorted(told) == sorted(emcy(code, register, detail) for detail in details)
    assert state_of_output(topcon) & 0x8001 == (0x8000 if details else 0x0001)
    if details:
        assert reset(topcon) != NO_ERROR  # while the cause is there
        topcon.clear(fault)
        topcon.run(5.0)
        assert reset(topcon) == NO_ERROR
        assert state_of_output(topcon) & 0x8001 == 0


@pytest.mark.spec("T-193", "A-83")
def test_the_dc_link_is_low_only_after_20_ms(topcon):
    topcon.inject("mains", volts=339.9)
    topcon.run(0.019)
    assert emcy(0x3200, 0x05, 0x49) not in topcon.sent
    topcon.run(0.002)
    assert topcon.sent[-1] == emcy(0x3200, 0x05, 0x49)


@pytest.mark.spec("A-53", "A-83")
@pytest.mark.parametrize(
    ("volts", "warned"), [(356, True), (358, False), (436, False), (438, True)]
)
def test_mains_near_a_limit_are_a_warning(topcon, volts, warned):
    topcon.inject("mains", volts=volts)
    topcon.run(0.1)
    assert state_of_output(topcon) == (0x4000 if warned else 0)


@pytest.mark.spec("T-193", "A-83")
@pytest.mark.parametrize(("volts", "detail"), [(339, 0x145), (461, 0x144)])
def test_a_regenerating_unit_watches_the_mains_itself(unit_file, volts, detail):
    bench = Bench("topcon", node_id=5, unit="MINE", unit_file=unit_file(regenerative=True))
    bench.inject("mains", volts=volts)
    assert bench.run(0.1) == [emcy(0x3100, 0x05, detail)]


@pytest.mark.spec("T-193", "A-47", "A-83")
def test_an_open_interlock_lets_nothing_start_and_nothing_be_reset(topcon):
    topcon.inject("interlock_open")
    assert topcon.run(0.001) == [emcy(0x9000, 0x81, 0xF2)]
    run(topcon, voltage=2000)
    assert state_of_output(topcon) == 0x8000
    reset(topcon)
    assert state_of_output(topcon) == 0x8000
    topcon.clear("interlock_open")
    assert reset(topcon) == NO_ERROR
    topcon.run(1.0)
    assert state_of_output(topcon) == 0
    topcon.sdo["Run command"].raw = 1
    assert state_of_output(topcon) == 0x0003


@pytest.mark.spec("A-76", "A-83")
def test_a_cause_outlives_a_power_cycle(topcon):
    topcon.inject("interlock_open")
    topcon.power_off()
    topcon.power_on()
    assert topcon.run(0.1) == [emcy(0x9000, 0x81, 0xF2)]
    topcon.clear()
    assert reset(topcon) == NO_ERROR


@pytest.mark.spec("T-194", "A-74", "A-83")
@pytest.mark.parametrize(("connection", "count"), [("parallel", 0xD6), ("series", 0xD5)])
def test_a_slave_that_falls_silent_is_missing_at_the_reset(connection, count):
    bench = Bench("topcon", node_id=5, units=3, connection=connection)
    run(bench, voltage=2000)
    bench.run(1.0)
    bench.inject("slave_silent")
    assert bench.run(0.099) == []
    assert bench.run(0.002) == [emcy(0x8100, 0x11, 0x67)]
    assert state_of_output(bench) == 0x8000
    reset(bench)
    assert bench.sent[-2:] == [emcy(0x7000, 0x81, count), emcy(0x7000, 0x81, 0xDA)]
    bench.clear()
    assert reset(bench) == NO_ERROR
    bench.sdo["Run command"].raw = 1
    assert state_of_output(bench) == 0x0003


@pytest.mark.spec("T-194", "A-74")
def test_a_single_unit_has_no_slave_to_lose(topcon):
    topcon.inject("slave_silent")
    assert topcon.run(1.0) == []


@pytest.mark.spec("A-60", "A-63")
def test_errors_of_the_card_are_told_once_and_end_with_the_reset(topcon):
    for code in CARD_CODES:
        topcon.inject("card_error", code=code)
        topcon.inject("card_error", code=code)
    assert len(topcon.sent) == 1 + len(CARD_CODES)
    assert topcon.sdo["Error Register"].raw == 0x11
    assert reset(topcon) == NO_ERROR
    assert topcon.sdo["Error Register"].raw == 0
