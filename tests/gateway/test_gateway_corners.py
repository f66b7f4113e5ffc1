"""Corners of the manual in which a master or a service engineer would be misled."""

import pytest

from canopen_twins import Bench
from canopen_twins.devices.gateway.model.canopen_side import FirstTpdo, TpdoFrame
from canopen_twins.devices.gateway.model.state import GatewayState, MasterCommand

from .bus import START, heard, read

PLAIN = {
    "governor": {
        **dict.fromkeys((4900, 4901, 4906, 4917, 4827, 4835, 16460, 16472), 0),
        14401: 1,
        14402: 1,
    },
    "gateway": {429: 0},
}
OWN_IS_PARTNER = {"gateway": {428: 1}}


@pytest.mark.spec("G-131", "G-141", "G-145")
def test_12419_stands_beside_12412_after_a_reset_of_the_gateway_alone(rig):
    rig = rig(PLAIN, OWN_IS_PARTNER)
    rig.system.power_on()
    rig.run(3.0)
    assert rig.governor.desk.read(12412) == 1
    rig.gateway.reset()
    rig.run(3.0)
    for unit in (rig.governor, rig.gateway):
        assert [unit.desk.read(number) for number in (12411, 12412, 12419)] == [0, 1, 1]


@pytest.mark.spec("G-130", "G-140", "G-141")
def test_12411_stands_beside_12412_after_a_reset_of_the_governor_alone(rig):
    rig = rig(PLAIN, OWN_IS_PARTNER)
    rig.system.power_on()
    rig.run(3.0)
    rig.governor.reset()
    rig.run(3.0)
    for unit in (rig.governor, rig.gateway):
        assert [unit.desk.read(number) for number in (12411, 12412, 12419)] == [1, 1, 0]


@pytest.mark.spec("G-132", "G-141")
def test_neither_stands_beside_12412_after_a_reset_of_both(rig):
    rig = rig(PLAIN, OWN_IS_PARTNER)
    for _ in range(2):
        rig.system.power_on()
        rig.run(3.0)
        assert [rig.gateway.desk.read(number) for number in (12411, 12412, 12419)] == [0, 1, 0]


def tpdo1(rig, seconds=0.1):
    frames = [each for _, each in rig.run(seconds) if isinstance(each, TpdoFrame)]
    return [frame.words[0] for frame in frames if frame.number == 1]


@pytest.fixture
def binary(rig):
    """A gateway that stands in Pre-Operational, with the errors in TPDO1."""

    def binary(first):
        return rig(PLAIN, {"governor": {14402: 0}}, first_tpdo=first).on()

    return binary


@pytest.mark.spec("G-042")
@pytest.mark.parametrize("first", [FirstTpdo.NONZERO, FirstTpdo.NEVER])
def test_a_change_before_operational_is_told_in_it(binary, first):
    rig = binary(first)
    rig.governor.fail(3001)
    rig.run(0.1)
    rig.system.command(MasterCommand.OPERATIONAL)
    assert tpdo1(rig) == [0x0002]
    assert tpdo1(rig, 1.0) == []


@pytest.mark.spec("G-042")
@pytest.mark.parametrize("first", [FirstTpdo.NONZERO, FirstTpdo.NEVER])
def test_a_change_between_two_operational_periods_is_told_in_the_second(binary, first):
    rig = binary(first)
    rig.system.command(MasterCommand.OPERATIONAL)
    rig.governor.fail(3001)
    assert tpdo1(rig) == [0x0002]
    rig.system.command(MasterCommand.PRE_OPERATIONAL)
    rig.governor.mend(3001)
    rig.run(0.1)
    rig.system.command(MasterCommand.OPERATIONAL)
    assert tpdo1(rig) == [0]
    rig.system.command(MasterCommand.STOP)
    rig.system.command(MasterCommand.OPERATIONAL)
    assert tpdo1(rig) == []


@pytest.mark.spec("G-042")
@pytest.mark.parametrize("first", [FirstTpdo.NONZERO, FirstTpdo.NEVER])
def test_a_change_is_told_across_another_initialisation(binary, first):
    rig = binary(first)
    rig.system.command(MasterCommand.OPERATIONAL)
    rig.governor.fail(3001)
    assert tpdo1(rig) == [0x0002]
    rig.system.command(MasterCommand.RESET_NODE)
    rig.governor.mend(3001)
    rig.run(0.5)
    assert rig.system.state is GatewayState.PRE_OPERATIONAL
    rig.system.command(MasterCommand.OPERATIONAL)
    assert tpdo1(rig) == [0]


@pytest.mark.spec("G-191")
@pytest.mark.parametrize(("volts", "low"), [(7.5, 0), (7.49, 1), (7.4999, 1), (7.0, 1)])
def test_the_supply_is_low_below_7_5_v_and_not_where_it_is_rounded(volts, low):
    bench = Bench("gateway")
    bench.run(0.3)
    bench.inject("supply", volts=volts)
    bench.run(0.1)
    assert bench.device.gateway[3085] == low
    assert bench.device.gateway["PowerSupply"] == pytest.approx(volts, abs=0.051)


def test_the_timer_counts_milliseconds_and_is_told_in_seconds():
    bench = Bench("gateway")
    bench.run(0.5)
    before = bench.device.gateway["Timer"]
    bench.run(1.5)
    assert bench.device.gateway["Timer"] - before == pytest.approx(1.5)
    bench.run(65.536)
    assert bench.device.gateway["Timer"] - before == pytest.approx(1.5)
    parameter = bench.device.system.gateway.parameters[3870]
    assert (parameter.unit, parameter.high) == ("s", 65.535)


def test_the_timer_runs_in_the_bootloader_as_well():
    bench = Bench("gateway")
    bench.run(0.3)
    bench.inject("bootloader", status=9)
    bench.run(3.0)
    assert bench.device.gateway["Timer"] == pytest.approx(3.0)


# 9.3.3: what is printed of 3801 to 3803
PRINTED = {
    2: (0, 0, 0),
    3: (None, 0, 0),
    5: (0xFFFF, 0xFFFF, 0),
    6: (None, None, 0xFFFF),
    7: (0xFFFF, 0xFFFF, 0),
    8: (None, None, 0xFFFF),
    9: (None, None, 0),
    10: (0, 0, 0),
}


@pytest.mark.spec("G-211", "G-212", "G-214")
@pytest.mark.parametrize("status", range(1, 11))
def test_the_bootloader_tells_what_its_test_has_found(status):
    bench = Bench("gateway")
    bench.run(0.3)
    bench.inject("bootloader", status=status)
    bench.run(1.0)
    values = [bench.device.gateway[number] for number in (3801, 3802, 3803)]
    for value, printed in zip(values, PRINTED.get(status, ()), strict=False):
        assert printed in (None, value)
    if status == 1:  # an address, what was written there, and what was read
        assert values[0]
        assert values[1] != values[2]
    if status == 4:
        assert values[1] | values[2] << 16 > 0x100000  # longer than any flash of it
    if status == 9:
        assert values[0] != values[1]


@pytest.mark.spec("G-213")
def test_the_watchdog_tells_address_and_flags():
    bench = Bench("gateway")
    bench.run(0.3)
    bench.inject("watchdog", address=0x12345, flags=0x80)
    bench.run(1.0)
    shown = [bench.device.gateway[number] for number in range(3095, 3099)]
    assert shown == [3, 0x2345, 0x0001, 0x0080]


@pytest.mark.spec("G-192")
def test_default_data_are_shown_where_they_act(tmp_path):
    file = tmp_path / "plant.yaml"
    file.write_text("version: 1\ngateway: {429: 200, 427: 5}\n")
    bench = Bench("gateway", config=str(file))
    bench.run(0.3)
    desk = bench.device.gateway
    assert (bench.device.node_id, desk["CanOpHeartBeatTxTime"]) == (5, 200)
    bench.inject("eeprom", code=0x20)
    assert bench.device.node_id == 1
    bench.run(0.5)
    assert (bench.device.node_id, desk["CanOpHeartBeatTxTime"], desk[427]) == (1, 1000, 1)
    assert read(bench, 0x1017) == 1000
    bench.clear("eeprom")
    bench.run(0.5)
    assert (bench.device.node_id, desk["CanOpHeartBeatTxTime"]) == (5, 200)


@pytest.mark.spec("G-192", "G-005")
def test_what_is_saved_over_default_data_is_all_that_was_saved(tmp_path):
    file = tmp_path / "plant.yaml"
    file.write_text("version: 1\ngateway: {429: 200, 430: 500}\n")
    bench = Bench("gateway", config=str(file))
    bench.run(0.3)
    bench.inject("eeprom", code=0x20)
    bench.run(0.5)
    desk = bench.device.gateway
    desk[429] = 300
    desk.save()
    assert desk[429] == 300
    bench.clear("eeprom")
    bench.run(0.5)
    assert (desk[429], desk[430]) == (300, 0)


REQUEST = "601#4000100000000000"


def burst(count, **settings):
    bench = Bench("gateway", config="gateway_plain.yaml", **settings)
    bench.run(0.3)
    bench.send(START)
    bench.run(0.1)
    for _ in range(count):
        bench.send(REQUEST)
    return bench, bench.run(0.5)


@pytest.mark.spec("G-150", "G-189")
def test_two_thousand_requests_in_no_time_are_too_many():
    bench, sent = burst(2000, answer_time=0.002)
    assert heard(sent, "581") == []
    assert "701#04" in sent
    assert read_word(bench) == 0x2000


@pytest.mark.spec("G-150")
@pytest.mark.parametrize(("count", "stopped"), [(33, False), (34, True)])
def test_thirty_two_requests_may_wait_for_the_one_that_is_answered(count, stopped):
    bench, sent = burst(count, answer_time=0.002)
    assert (bench.device.report["state"] == "Stopped") is stopped
    assert len(heard(sent, "581")) == (0 if stopped else count)


def test_an_ideal_gateway_answers_them_all():
    bench, _ = burst(2000)
    assert bench.device.report["state"] == "Operational"
    assert read_word(bench) == 0


def test_requests_at_the_pace_of_the_answers_never_overflow():
    bench, _ = burst(0, answer_time=0.002)
    for _ in range(500):
        bench.send(REQUEST)
        bench.run(0.002)
    assert bench.device.report["state"] == "Operational"


@pytest.mark.spec("G-150", "G-189", "G-029")
@pytest.mark.parametrize(("count", "word"), [(64, 0), (65, 0x2000)])
def test_a_burst_of_pdos_overflows_the_receive_buffer_and_begins_anew(configured, count, word):
    bench = configured({835: -5, 4835: 3}, answer_time=0.002)
    bench.send(START)
    bench.run(0.1)
    for _ in range(count):
        bench.send("201#0000")
    sent = bench.run(0.5)
    assert ("701#00" in sent) is bool(word)
    assert read_word(bench) == word


def read_word(bench):
    """2005h, whatever the state."""
    return bench.device.system.value(0x2005, 0)
