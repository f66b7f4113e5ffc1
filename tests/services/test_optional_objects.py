"""A dictionary with the mandatory objects and PDOs only: services do without what is not there."""

import pytest
from probe import Probe

from canopen_twins import Bench

MISSING = (0x1003, 0x1005, 0x1008, 0x1010, 0x1011, 0x1014, 0x1016, 0x1017, 0x1200)


class Bare(Probe):
    def dictionary(self):
        od = super().dictionary()
        for index in MISSING:
            del od[index]
        return od


@pytest.fixture
def bare():
    probe = Bare()
    probe.stored = ()
    return Bench.of({"bare": probe})


def test_it_boots_and_is_started(bare):
    assert bare.sent == ["705#00"]
    assert bare.send("000#0105") == ["185#000000"]
    assert bare.run(10.0) == []


@pytest.mark.spec("T-038")
@pytest.mark.parametrize("index", MISSING)
def test_what_is_missing_does_not_exist(bare, index):
    multiplexer = index.to_bytes(2, "little").hex().upper() + "01"
    assert bare.send(f"605#40{multiplexer}00000000") == [f"585#80{multiplexer}00000206"]


def test_sync_comes_on_its_default_identifier(bare):
    bare.send("000#0105")
    assert bare.send("080#") == ["285#00000000"]


def test_emergencies_go_out_on_their_default_identifier(bare):
    bare.inject("error", code=0x2310)
    assert bare.sent[-1][:8] == "085#1023"
    assert bare.sdo["Error register"].raw == 1
