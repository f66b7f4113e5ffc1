import pytest

from canopen_twins import Bench, UserError
from canopen_twins.devices.gateway.faults import HEALS
from canopen_twins.slave.service import State

from .bus import BOOT_UP, ENTER_PREOP, START, heard, read, word

QUIET = ({16460: 0, 16472: 0, 14401: 0}, {429: 0})
SENSORS = dict.fromkeys((4900, 4901, 4906, 4917, 4827, 4835), 3)


@pytest.fixture
def operational(configured):
    """Build a bench in Operational that is quiet, but for what a test configures."""

    def operational(governor=(), gateway=()):
        bench = configured({**QUIET[0], **dict(governor)}, {**QUIET[1], **dict(gateway)})
        bench.send(START)
        bench.run(0.1)
        return bench

    return operational


@pytest.mark.spec("G-130", "G-131", "G-132", "G-133")
@pytest.mark.parametrize(
    ("unit", "expected"), [("governor", 0x0001), ("gateway", 0x0100), ("both", 0)]
)
def test_a_reset_of_a_unit(operational, unit, expected):
    bench = operational()
    bench.inject("reset", unit=unit)
    assert bench.run(0.5) == [BOOT_UP]
    assert word(bench) == expected
    assert bench.twin.node.state is State.PRE_OPERATIONAL


@pytest.mark.spec("G-131", "G-012")
def test_a_gateway_in_reset_is_off_the_bus_at_once(operational):
    bench = operational()
    bench.inject("reset", unit="gateway")
    assert bench.send("601#4000100000000000") == []
    assert bench.twin.node.state is State.INITIALISING


@pytest.mark.spec("G-198", "G-148")
def test_a_governor_that_is_late():
    bench = Bench("gateway")
    bench.inject("governor_late", seconds=5)
    assert bench.run(5.0) == []
    assert bench.device.gateway[12422] == 1
    assert bench.run(0.1) == [BOOT_UP]
    assert word(bench) == 0x0800
    bench.clear("governor_late")
    bench.inject("reset", unit="governor")
    assert bench.run(0.4) == [BOOT_UP]


@pytest.mark.spec("G-144", "G-148")
@pytest.mark.parametrize(
    ("direction", "expected"), [("both", 0x0810), ("to_gateway", 0x0800), ("to_governor", 0x0010)]
)
def test_a_cut_link(operational, direction, expected):
    bench = operational()
    bench.inject("link_cut", direction=direction)
    bench.run(1.5)
    assert bench.twin.node.state is State.INITIALISING
    bench.clear("link_cut")
    assert bench.run(0.5) == [BOOT_UP]
    assert word(bench) == expected


@pytest.mark.spec("G-024", "G-029")
@pytest.mark.parametrize("direction", HEALS["direction"].examples)
def test_a_link_that_is_cut_as_a_hunt_does_it_needs_nobody_who_clears_an_error(direction):
    """Just when the gateway is Pre-operational, the end of the handshake is on its way."""
    bench = Bench("gateway", config="gateway_plant.yaml")
    bench.inject("link_cut", direction=direction)
    bench.run(2.0)
    bench.clear("link_cut")
    bench.run(1.0)
    assert bench.twin.node.state is State.PRE_OPERATIONAL


def test_a_slow_link_delays_the_boot_up(operational):
    bench = operational()
    bench.inject("link_delay", milliseconds=50)
    bench.inject("reset")
    assert bench.run(0.25) == []
    assert bench.run(0.5) == [BOOT_UP]
    bench.clear("link_delay")
    bench.inject("reset", unit="both")
    assert bench.run(0.25) == [BOOT_UP]


@pytest.mark.spec("G-027")
def test_lost_telegrams_cost_an_attempt(operational):
    bench = operational()
    bench.send("000#8101")
    bench.inject("link_drop", count=2, direction="to_governor")
    assert bench.run(0.1) == []
    assert bench.run(1.0) == [BOOT_UP]


@pytest.mark.spec("G-149", "G-188", "G-007", "G-016")
@pytest.mark.parametrize(("period", "sign"), [(0, "701#00"), (60000, "701#7F")])
def test_a_fault_of_the_canopen_bus(operational, period, sign):
    bench = operational(gateway={429: period})
    bench.inject("can2_bus_fault")
    assert bench.send("601#4000100000000000") == []
    bench.send("000#8101")
    assert bench.run(1.2) == []
    bench.clear("can2_bus_fault")
    assert bench.run(0.5) == [sign]
    assert bench.twin.node.state is State.PRE_OPERATIONAL
    assert word(bench) == 0x1000
    bench.send(START)
    assert word(bench) == 0


@pytest.mark.spec("G-149", "G-026")
def test_an_initialisation_during_a_bus_fault_is_not_heard(operational):
    bench = operational()
    bench.inject("can2_bus_fault")
    bench.inject("reset", unit="both")
    assert bench.run(0.4) == []
    assert bench.device.system.state.value == "Pre-Operational"
    assert bench.send("601#4000100000000000") == []
    bench.clear("can2_bus_fault")
    assert bench.run(0.6) == [BOOT_UP]


@pytest.mark.spec("G-150", "G-148", "G-189")
@pytest.mark.parametrize(
    ("fault", "expected"), [("can1_receive_overflow", 0x0800), ("can2_receive_overflow", 0x2000)]
)
def test_an_overflow_of_a_receive_buffer(operational, fault, expected):
    bench = operational()
    bench.inject(fault)
    assert bench.twin.node.state is State.INITIALISING
    assert bench.run(0.5) == [BOOT_UP]
    assert word(bench) == expected


@pytest.mark.spec("G-150", "G-189", "G-015", "G-034")
@pytest.mark.parametrize(("command", "expected"), [(START, 0), (ENTER_PREOP, 0x2000)])
def test_an_overflow_of_the_sdo_transmit_buffer(operational, command, expected):
    bench = operational(gateway={429: 16})
    bench.inject("sdo_transmit_overflow")
    assert bench.twin.node.state is State.STOPPED
    assert set(bench.run(1.0)) == {"701#04"}
    assert bench.send("601#4000100000000000") == []
    bench.send(command)
    assert word(bench) == expected


@pytest.mark.spec("G-115", "G-146")
def test_a_partner_that_is_lost(operational):
    bench = operational({14401: 1}, {428: 127, 430: 100})
    for _ in range(5):
        bench.send("77F#05")
        bench.run(0.05)
    bench.inject("partner_lost")
    for _ in range(5):
        bench.send("77F#05")
        bench.run(0.05)
    assert word(bench) == 0x0200
    assert heard(bench.sent, "281")[-1] == "00040000"  # 3074
    bench.clear("partner_lost")
    bench.send("77F#05")
    bench.run(0.05)
    assert word(bench) == 0
    assert heard(bench.sent, "281")[-1] == "00000000"


def feed(bench, times=5):
    for _ in range(times):
        for frame in ("201#000000000000", "301#00000000", "401#000000000000"):
            bench.send(frame)
        bench.send("501#0000000000000000")
        bench.run(0.05)


@pytest.mark.spec("G-122", "G-123", "G-142")
def test_an_rpdo_that_is_lost(operational):
    bench = operational({**SENSORS, 14401: 1, 16481: 100})
    feed(bench)
    assert (word(bench), heard(bench.sent, "181")[-1]) == (0, "0000000000000000")
    bench.inject("rpdo_lost", number=2)
    feed(bench)
    assert word(bench) == 0x0004
    assert heard(bench.sent, "181")[-1] == "6000000000000000"  # 3005 and 3006
    bench.clear("rpdo_lost")
    feed(bench)
    assert (word(bench), heard(bench.sent, "181")[-1]) == (0, "0000000000000000")


@pytest.mark.spec("G-109", "G-163")
def test_a_sensor_flag(operational):
    bench = operational({**SENSORS, 14401: 1})
    feed(bench)
    bench.inject("sensor_flag", channel=7)
    feed(bench)
    assert (word(bench), heard(bench.sent, "181")[-1]) == (0, "0008000000000000")  # 3011
    bench.clear("sensor_flag")
    feed(bench)
    assert heard(bench.sent, "181")[-1] == "0000000000000000"


@pytest.mark.spec("G-143", "G-147", "G-186")
@pytest.mark.parametrize(("unit", "expected"), [("gateway", 0x0C10), ("governor", 0x0818)])
def test_a_fault_of_the_heinzmann_can(operational, unit, expected):
    bench = operational()
    bench.inject("can1_bus_fault", unit=unit)
    bench.run(1.5)
    assert getattr(bench.device, unit)[3070] == 1
    assert bench.twin.node.state is State.INITIALISING
    bench.clear("can1_bus_fault")
    bench.run(0.5)
    assert word(bench) == expected


@pytest.mark.spec("G-195")
@pytest.mark.parametrize(
    ("fault", "parameters", "number", "value"),
    [
        ("duplicate_number", {}, 2404, 1),
        ("heinzmann_overflow", {"buffer": "transmit"}, 2401, 2),
        ("heinzmann_overflow", {"buffer": "receive"}, 2402, 2),
    ],
)
def test_trouble_with_numbers_and_buffers(operational, fault, parameters, number, value):
    bench = operational()
    bench.inject(fault, unit="gateway", **parameters)
    bench.run(0.1)
    assert (bench.device.gateway[number], bench.device.gateway[3071]) == (value, 1)
    assert bench.twin.node.state is State.INITIALISING
    bench.clear(fault)
    bench.run(0.5)
    assert bench.device.gateway[number] == 0
    assert bench.twin.node.state is State.PRE_OPERATIONAL


@pytest.mark.spec("G-191")
def test_a_supply_that_is_too_low(operational):
    bench = operational({14401: 1})
    bench.inject("supply", volts=7.0)
    assert bench.run(0.1) == ["281#00002000"]  # bit 85
    assert read(bench, 0x1001) & 0b100
    bench.clear("supply")
    assert bench.run(0.1) == ["281#00000000"]


def errors_of(bench, unit):
    units = bench.device.system._units
    (known,) = (each.parameters for each in units if each.which.value == unit)
    return [number for number in known if 3000 <= number < 3095]


@pytest.mark.spec("G-180")
@pytest.mark.parametrize("unit", ["gateway", "governor"])
def test_every_error_of_a_unit_can_be_had(configured, unit):
    bench = configured()
    for number in errors_of(bench, unit):
        try:
            bench.inject("error", unit=unit, number=number)
            fault = "error"
        except UserError as refusal:
            (_, fault, _) = str(refusal).split("'")
            known = bench.device.faults[fault].parameters
            status = {3076: 10, 3078: 1, 3087: 2}.get(number)
            given = {"unit": unit} if "unit" in known else {}
            bench.inject(fault, **given, **({"status": status} if status else {}))
        if number == 3073:
            assert bench.device.system.gateway.memory.has(number)
        bench.run(2.5 if number == 3074 else 0.3)
        if number != 3073:  # for a moment only
            assert getattr(bench.device, unit)[number] == 1
        bench.clear()
        bench.inject("clear_errors")
        bench.inject("reset", unit="both")
        bench.run(0.5)
        assert word(bench) == 0


@pytest.mark.spec("G-193")
def test_an_exception_is_kept(operational):
    bench = operational()
    bench.inject("exception", number=2, address=0x12345, flags=7)
    bench.run(0.1)
    assert [bench.device.gateway[number] for number in range(3195, 3199)] == [2, 0x2345, 1, 7]
    assert bench.twin.node.state is State.INITIALISING


@pytest.mark.spec("G-211", "G-212", "G-214")
@pytest.mark.parametrize(("status", "number"), [(1, 3078), (9, 3087), (10, 3076)])
def test_a_unit_that_stays_in_its_bootloader(operational, status, number):
    bench = operational()
    bench.inject("bootloader", unit="gateway", status=status)
    assert bench.run(2.0) == []
    assert (bench.device.gateway[3800], bench.device.gateway[number]) == (status, 1)
    bench.clear("bootloader")
    assert bench.run(0.5) == [BOOT_UP]


@pytest.mark.spec("G-213")
def test_a_watchdog_that_bites(operational):
    bench = operational()
    bench.inject("watchdog", unit="gateway", address=0x4321)
    assert bench.run(2.0) == []
    assert [bench.device.gateway[n] for n in (3089, 3095, 3096)] == [1, 3, 0x4321]


@pytest.mark.spec("G-210")
@pytest.mark.parametrize("test", ["watchdog", "checksum", "ram"])
def test_an_endless_loop_answers_nobody(operational, test):
    bench = operational()
    bench.inject("endless_loop", unit="both", test=test)
    assert bench.run(600.0) == []
    with pytest.raises(UserError, match="no answer, the unit is kept in the bootloader"):
        bench.device.gateway[3800]
    bench.clear("endless_loop")
    assert bench.run(0.5) == [BOOT_UP]


@pytest.mark.spec("G-192")
def test_a_serial_number_that_cannot_be_displayed_is_not_told_to_the_master_either(operational):
    bench = operational()
    known = read(bench, 0x1018, 4)
    bench.inject("eeprom", unit="gateway", code=1 << 3)
    bench.run(0.5)
    assert (read(bench, 0x1018, 4), bench.device.gateway[3844]) == (0, 0)
    bench.clear("eeprom")
    bench.run(0.5)
    assert read(bench, 0x1018, 4) == known != 0


@pytest.mark.spec("G-192")
def test_a_damaged_eeprom(operational):
    bench = operational({}, {428: 9})
    bench.inject("eeprom", unit="gateway", code=1 << 5)
    bench.run(0.5)
    assert (bench.device.gateway[3099], read(bench, 0x1017)) == (32, 1000)  # default data
    bench.clear("eeprom")
    bench.run(0.5)
    assert (bench.device.gateway[3099], read(bench, 0x1017)) == (0, 0)


@pytest.mark.spec("G-075", "G-076", "G-077", "G-078", "G-024")
@pytest.mark.parametrize(
    ("fault", "parameters"),
    [
        ("duplicate_identifier", {}),
        ("reserved_identifier", {}),
        ("reserved_identifier", {"identifier": 0x601}),
        ("partner_is_own_node", {}),
    ],
)
def test_a_configuration_that_cannot_be_performed(operational, fault, parameters):
    bench = operational()
    bench.inject(fault, **parameters)
    assert bench.run(5.0) == []
    assert bench.device.gateway[12412] == 1
    bench.power_off()
    bench.power_on()
    assert bench.run(5.0) == []
    bench.clear(fault)
    assert bench.run(0.5) == [BOOT_UP]
    assert word(bench) == 0


def test_a_load_step(operational):
    bench = operational()
    bench.run(20.0)
    bench.set(load=50)
    bench.run(10.0)
    bench.inject("load_step", kilowatts=100)
    assert bench.device.report["load [kW]"] == 150
    bench.run(0.5)
    assert 1400 < bench.device.report["speed [rpm]"] < 1450
    bench.clear("load_step")
    assert bench.device.report["load [kW]"] == 50


def test_overspeed_stops_the_engine_until_the_errors_are_cleared(operational):
    bench = operational({14401: 1, 14402: 1})
    bench.run(20.0)
    bench.inject("overspeed")
    sent = bench.run(0.1)
    assert heard(sent, "181") == ["1000000000000000"]  # 3004
    assert int(heard(sent, "381")[-1][:2], 16) & 0x80
    bench.run(60.0)
    assert bench.device.report["speed [rpm]"] == 0
    bench.inject("clear_errors")
    bench.run(10.0)
    assert bench.device.report["speed [rpm]"] > 700


@pytest.mark.parametrize(
    ("fault", "parameters", "told"),
    [
        ("reset", {"unit": "motor"}, "unknown unit 'motor'"),
        ("link_cut", {"direction": "up"}, "unknown direction 'up'"),
        ("link_delay", {"milliseconds": 0}, "milliseconds 0 is not in 1..1000"),
        ("link_drop", {"count": 0}, "count 0 is not above 0"),
        ("rpdo_lost", {"number": 5}, "number 5 is not in 1..4"),
        ("sensor_flag", {"channel": 0}, "channel 0 is not in 1..12"),
        ("supply", {"volts": 56}, "56.0 V is not in 0..55"),
        ("error", {"number": 3074}, "comes by the fault 'reserved_identifier'"),
        ("error", {"number": 3050}, "error 3050 is no inner error of the gateway"),
        ("bootloader", {"status": 11}, "11 is not in 1..10"),
        ("endless_loop", {"test": "x"}, "unknown test 'x'"),
        ("heinzmann_overflow", {"buffer": "x"}, "unknown buffer 'x'"),
        ("reserved_identifier", {"identifier": 0x800}, "2048 is not in 0..2047"),
        ("governor_late", {"seconds": 0}, "seconds 0 is not above 0"),
        ("overspeed", {"rpm": 0}, "rpm 0 is not above 0"),
    ],
)
def test_what_cannot_happen_is_refused_in_one_line(configured, fault, parameters, told):
    bench = configured()
    with pytest.raises(UserError) as refusal:
        bench.inject(fault, **parameters)
    assert told in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert bench.twin.node.faults.active == {}
