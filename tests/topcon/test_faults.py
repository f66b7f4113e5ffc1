import csv

import pytest

from canopen_twins import UserError
from canopen_twins.files.shipped import od_file

from .bus import emcy, reset, state_of_output

NO_ERROR = "085#0000000000000000"
CARD_CODES = (0x5000, 0x8110, 0x8111, 0x8112, 0x8200)


def messages():
    with od_file("topcon_emcy.csv") as path, path.open(encoding="ascii", newline="") as file:
        for row in csv.DictReader(file):
            yield tuple(int(row[key], 16) for key in ("code", "register", "detail"))


def inject(bench, code, detail):
    """By number, if it is an error of the unit, else by code; True for the unit (A-63)."""
    if detail or code == 0x6100:
        bench.inject("error", number=detail)
        return True
    bench.inject("card_error", code=code)
    return False


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
        ("mains", {"hertz": 39}, "less than 40"),
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


@pytest.mark.spec("A-60", "A-63")
def test_errors_of_the_card_are_told_once_and_end_with_the_reset(topcon):
    for code in CARD_CODES:
        topcon.inject("card_error", code=code)
        topcon.inject("card_error", code=code)
    assert len(topcon.sent) == 1 + len(CARD_CODES)
    assert topcon.sdo["Error Register"].raw == 0x11
    assert reset(topcon) == NO_ERROR
    assert topcon.sdo["Error Register"].raw == 0
