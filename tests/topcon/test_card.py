import pytest

from canopen_twins import Bench, UserError

from .bus import RESET_NODE

BIT_RATES = {1: 10_000, 2: 20_000, 3: 50_000, 4: 125_000, 5: 250_000, 6: 500_000, 7: 800_000}


@pytest.mark.spec("T-001", "T-002", "T-003")
@pytest.mark.parametrize(
    ("ah", "al", "boot_up"),
    [(1, 0xD, "71D#00"), (0, 0, "701#00"), (0, 1, "701#00"), (1, 0, "710#00"), (7, 0xF, "77F#00")],
)
def test_the_module_id_is_16_times_ah_plus_al(ah, al, boot_up):
    assert Bench("topcon", ah=ah, al=al).sent == [boot_up]


@pytest.mark.spec("T-001")
def test_all_identifiers_follow_the_module_id():
    bench = Bench("topcon", ah=1, al=0xD)
    bench.send("000#011D")
    assert bench.send("61D#4014100000000000") == ["59D#431410009D000000"]
    assert bench.send("19D#R") == ["19D#0000000000000000"]
    bench.inject("error", number=0x23)
    assert bench.sent[-1] == "09D#0023032300000000"


@pytest.mark.spec("T-003", "A-04")
@pytest.mark.parametrize("ah", range(8, 16))
def test_a_module_id_above_127_is_refused_before_anything_is_on_the_bus(ah):
    with pytest.raises(UserError) as refusal:
        Bench("topcon", ah=ah, al=0)
    assert str(refusal.value) == f"AH={ah} and AL=0 are module id {16 * ah}: the highest is 127"


@pytest.mark.spec("T-003", "A-04")
@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        ({"node_id": 0}, "node id 0 is not in 1..127"),
        ({"node_id": 128}, "node id 128 is not in 1..127"),
        ({"ah": 16, "al": 0}, "setting 'ah' is 0 to 15, not 16"),
        ({"ah": 0, "al": -1}, "setting 'al' is 0 to 15, not -1"),
        ({"br": 16}, "setting 'br' is 0 to 15, not 16"),
    ],
)
def test_what_no_switch_can_be_turned_to_is_refused(settings, reason):
    with pytest.raises(UserError) as refusal:
        Bench("topcon", **settings)
    assert str(refusal.value) == reason


@pytest.mark.spec("T-004")
def test_switches_turned_while_powered_act_at_the_next_power_on():
    bench = Bench("topcon", ah=0, al=5, br=6)
    bench.set(ah=1, al=0xD, br=3)
    assert bench.send(RESET_NODE) == ["705#00"]
    assert bench.device.bit_rate == 500_000
    bench.power_off()
    bench.power_on()
    assert bench.sent[-1] == "71D#00"
    assert bench.device.bit_rate == 50_000


@pytest.mark.spec("T-003", "T-004", "A-04")
def test_switches_cannot_be_turned_to_a_module_id_that_does_not_exist():
    bench = Bench("topcon", ah=0, al=5)
    with pytest.raises(UserError, match="module id 133: the highest is 127"):
        bench.set(ah=8)
    bench.power_off()
    bench.power_on()
    assert bench.sent == ["705#00", "705#00"]


@pytest.mark.spec("T-005", "T-006", "A-05")
@pytest.mark.parametrize("br", range(16))
def test_the_bit_rate_is_that_of_the_table_or_else_250_kbit(br):
    assert Bench("topcon", br=br).device.bit_rate == BIT_RATES.get(br, 250_000)


@pytest.mark.spec("T-007")
def test_a_unit_is_delivered_for_500_kbit(topcon):
    assert topcon.device.bit_rate == 500_000


@pytest.mark.spec("T-003", "T-006", "A-06")
def test_the_switches_of_the_card_say_nothing_of_the_units_of_a_system():
    bench = Bench("topcon", ah=0, al=5, units=2)
    assert bench.sent == ["705#00"]
    assert bench.sdo["Maximum current"].raw == 200
