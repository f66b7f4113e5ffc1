import pytest

from canopen_twins import Bench

from .bus import RESET_COMMUNICATION, RESET_NODE, read, refused


def address(bench):
    return bench.sdo["Register Read/Write"]["Address"]


def value(bench):
    return bench.sdo["Register Read/Write"]["Value"]


@pytest.mark.spec("T-187", "A-56")
def test_a_register_is_addressed_and_then_read_or_written(topcon):
    address(topcon).raw = 0x1234
    assert value(topcon).raw == 0
    value(topcon).raw = 0xBEEF
    assert value(topcon).raw == 0xBEEF
    address(topcon).raw = 0x1235
    assert value(topcon).raw == 0
    address(topcon).raw = 0x1234
    assert value(topcon).raw == 0xBEEF


@pytest.mark.spec("T-187", "T-188")
def test_the_address_has_32_bits_and_the_value_16(topcon):
    assert read(topcon, 0x2100, 0) == ["585#4F00210002000000"]
    assert read(topcon, 0x2100, 1) == ["585#4300210100000000"]
    assert read(topcon, 0x2100, 2) == ["585#4B00210200000000"]


@pytest.mark.spec("T-188", "A-56", "A-19")
@pytest.mark.parametrize(
    ("firmware", "bits"),
    [
        ("V4.11.45", 16),
        ("V4.19.99", 16),
        ("V4.20", 24),
        ("V4.20.00", 24),
        ("V4.20.01", 24),
        ("V5.0.0", 24),
        ("V3.99.99", 16),
    ],
)
def test_the_width_of_addresses_is_that_of_the_firmware(firmware, bits):
    bench = Bench("topcon", firmware=firmware)
    address(bench).raw = highest = (1 << bits) - 1
    for wider in (1 << bits, 0xFFFFFFFF):
        with refused(0x06090031):
            address(bench).raw = wider
    assert address(bench).raw == highest


@pytest.mark.spec("A-56")
def test_the_address_stays_until_the_card_starts_anew(topcon):
    address(topcon).raw = 0x42
    value(topcon).raw = 7
    topcon.send(RESET_COMMUNICATION)
    assert (address(topcon).raw, value(topcon).raw) == (0x42, 7)
    topcon.send(RESET_NODE)
    assert address(topcon).raw == 0
    address(topcon).raw = 0x42
    assert value(topcon).raw == 7


@pytest.mark.spec("A-56", "A-86")
def test_registers_forget_their_values_with_the_power(topcon):
    address(topcon).raw = 0x42
    value(topcon).raw = 7
    topcon.power_off()
    topcon.power_on()
    assert address(topcon).raw == 0
    address(topcon).raw = 0x42
    assert value(topcon).raw == 0
