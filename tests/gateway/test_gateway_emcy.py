import pytest

from canopen_twins import Bench, UserError

from .bus import START, heard, read

QUIET = {16460: 0, 16472: 0, 14401: 0}


@pytest.fixture
def telling(configured):
    """With the extension, in Operational, and nothing else on the bus."""
    bench = configured(QUIET, {429: 0, 428: 127, 430: 100}, emcy="assumed")
    bench.send(START)
    bench.run(0.1)
    return bench


def test_the_device_itself_has_no_emergencies(bench):
    bench.send(START)
    bench.inject("supply", volts=7)
    bench.inject("reset", unit="governor")
    assert heard(bench.run(5.0), "081") == []
    assert (read(bench, 0x1003), read(bench, 0x1014)) == (-0x06020000, -0x06020000)


def test_the_extension_tells_every_change_of_2005h(telling):
    telling.send("77F#05")
    (frame,) = telling.run(0.2)
    assert frame == "081#3081110002000000"
    telling.send("77F#05")
    assert telling.run(0.05) == ["081#0000000000000000"]


def test_it_tells_resets_after_the_boot_up(telling):
    telling.inject("reset", unit="gateway")
    assert telling.run(0.5) == ["701#00", "081#0081110001000000"]
    assert telling.send(START) == ["081#0000000000000000"]


def test_it_tells_supply_and_both_at_once(telling):
    telling.inject("supply", volts=7)
    assert telling.run(0.1) == ["081#0031050000000000"]
    telling.clear("supply")
    assert telling.run(0.1) == ["081#0000000000000000"]


def test_a_tpdo_with_its_identifier_has_it_alone(configured):
    bench = configured({**QUIET, 16404: 2300, 16461: 100}, {16404: 0x081, 429: 0}, emcy="assumed")
    bench.inject("supply", volts=7)
    bench.send(START)
    assert {len(data) for data in heard(bench.run(1.0), "081")} == {4}


def test_it_is_off_by_default():
    assert Bench("gateway").device.settings.emcy == "none"


@pytest.mark.parametrize("fault", ["emcy_lost", "emcy_doubled"])
def test_an_emergency_cannot_be_lost_where_there_is_none(telling, fault):
    with pytest.raises(UserError, match="no emergency that could go wrong: this device has none"):
        Bench("gateway").inject(fault)
    telling.inject(fault)
