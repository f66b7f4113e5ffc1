import pytest

from canopen_twins.devices.gateway.model.canopen_side import BootUp, Heartbeat, TpdoFrame
from canopen_twins.devices.gateway.model.errors import CANOPEN_ERRORS, FATAL, CanopenError
from canopen_twins.devices.gateway.model.heinzmann_can import Command
from canopen_twins.devices.gateway.model.state import GatewayState, GovernorCommand, MasterCommand
from canopen_twins.devices.gateway.model.system import Buffer

NO_HEARTBEAT = {"gateway": {429: 0}}
OPERATIONAL = MasterCommand.OPERATIONAL


def messages(rig, seconds):
    return [message for _, message in rig.run(seconds)]


def both(rig, number):
    return [unit.desk.read(number) for unit in (rig.governor, rig.gateway)]


@pytest.mark.spec("G-054")
def test_table_2_gives_every_error_its_bit():
    bits = {number: error.bit_length() - 1 for number, error in CANOPEN_ERRORS.items()}
    assert bits == {12411 + k: k for k in (*range(5), *range(8, 14))}
    assert sum(CanopenError) == 0b0011_1111_0001_1111


@pytest.mark.spec("G-180", "G-181", "G-182", "G-191")
def test_a_low_supply_is_told_counted_and_gone_by_itself(plain):
    rig = plain().operational()
    for times in (1, 2):
        rig.gateway.feed(7.4)
        rig.run(0.1)
        assert (rig.gateway.desk.read(3085), rig.gateway.desk.read(3185)) == (1, times)
        rig.gateway.feed(7.5)
        rig.run(0.1)
        assert (rig.gateway.desk.read(3085), rig.gateway.desk.read(3185)) == (0, times)
    assert rig.system.state is GatewayState.OPERATIONAL


def test_the_lowest_supply_can_be_another(plain):
    rig = plain(lowest_voltage=18.0).on()
    rig.gateway.feed(17.0)
    rig.run(0.1)
    assert rig.gateway.desk.read(3085) == 1


@pytest.mark.spec("G-181", "G-182")
def test_present_errors_are_lost_without_power_and_counters_are_not(plain):
    rig = plain().on()
    rig.gateway.fail(3094)
    rig.run(0.1)
    rig.gateway.mend(3094)
    rig.gateway.power_off()
    rig.gateway.reset()
    rig.run(0.5)
    assert (rig.gateway.desk.read(3094), rig.gateway.desk.read(3194)) == (0, 1)
    rig.gateway.desk.clear_errors()
    assert rig.gateway.desk.read(3194) == 1
    rig.gateway.desk.clear_error_memory()
    assert rig.gateway.desk.read(3194) == 0


@pytest.mark.spec("G-181")
def test_counters_stop_at_255(plain):
    rig = plain().on()
    memory = rig.gateway.memory
    for _ in range(300):
        memory.update(1 << 94)
        memory.clear()
    assert rig.gateway.desk.read(3194) == 255


@pytest.mark.spec("G-183")
@pytest.mark.parametrize("where", ["governor", "gateway"])
def test_clearing_in_one_unit_clears_in_the_other(plain, where):
    rig = plain().on()
    rig.governor.fail(3094)
    rig.run(0.05)
    rig.governor.mend(3094)
    rig.run(0.05)
    assert rig.governor.desk.read(3094) == 1
    getattr(rig, where).desk.clear_errors()
    rig.run(0.05)
    assert rig.governor.desk.read(3094) == 0


@pytest.mark.spec("G-184")
def test_a_cleared_error_whose_cause_persists_is_reported_again(plain):
    rig = plain().on()
    rig.governor.fail(3094)
    rig.run(0.05)
    rig.governor.desk.clear_errors()
    assert rig.governor.desk.read(3094) == 0
    rig.run(0.05)
    assert (rig.governor.desk.read(3094), rig.governor.desk.read(3194)) == (1, 2)


@pytest.mark.spec("G-183", "G-184")
def test_clearing_is_not_counted_as_a_new_error(plain):
    rig = plain().operational()
    rig.gateway.reset()
    rig.run(0.5)
    for unit in (rig.governor, rig.gateway):
        unit.desk.clear_errors()
        assert both(rig, 12419)[unit is rig.gateway] == 0
    rig.run(0.1)
    assert (both(rig, 3074), both(rig, 3174)) == ([0, 0], [1, 1])


@pytest.mark.spec("G-184")
def test_what_the_gateway_cannot_clear_the_governor_learns_again_at_once(plain):
    rig = plain().on()
    rig.gateway.wiring.duplicate = True
    rig.run(0.1)
    rig.governor.desk.clear_errors()
    assert both(rig, 12422) == [0, 1]
    rig.run(0.004)
    assert both(rig, 12422) == [1, 1]


@pytest.mark.spec("G-190")
@pytest.mark.parametrize("number", FATAL)
def test_a_fatal_error_of_the_gateway_lasts_until_its_reset(plain, number):
    rig = plain(NO_HEARTBEAT).operational()
    rig.gateway.fail(number)
    rig.run(0.05)
    assert rig.system.state is GatewayState.UNDEFINED
    rig.gateway.mend(number)
    rig.gateway.desk.clear_errors()
    assert messages(rig, 3.0) == []
    assert rig.system.state is GatewayState.UNDEFINED
    assert rig.governor.desk.read(12412) == 0
    rig.gateway.reset()
    assert messages(rig, 0.5) == [BootUp()]


@pytest.mark.spec("G-193")
def test_an_exception_is_kept_with_its_place(plain):
    rig = plain().on()
    rig.gateway.break_off(2, address=0x12345678, flags=0x55AA)
    rig.run(0.05)
    rig.gateway.reset()
    rig.run(0.5)
    assert [rig.gateway.desk.read(3195 + k) for k in range(4)] == [2, 0x5678, 0x1234, 0x55AA]
    assert rig.system.state is GatewayState.UNDEFINED


def test_an_error_with_a_cause_of_its_own_cannot_be_made_up(plain):
    with pytest.raises(ValueError, match="error 3074 is no inner error of the gateway"):
        plain().gateway.fail(3074)


@pytest.mark.spec("G-143", "G-147", "G-186", "G-151")
@pytest.mark.parametrize(("unit", "own"), [("governor", 0x0008), ("gateway", 0x0400)])
def test_a_bus_error_of_can1_ends_communication_and_stays_visible(plain, unit, own):
    rig = plain(NO_HEARTBEAT).operational()
    faulty = getattr(rig, unit)
    faulty.wiring.bus_fault = True
    rig.run(0.3)
    assert faulty.desk.read(3070) == 1
    faulty.wiring.bus_fault = False
    rig.run(0.5)
    assert (rig.system.state, rig.word) == (GatewayState.PRE_OPERATIONAL, own)
    assert (faulty.desk.read(3070), both(rig, 3074)) == (0, [1, 1])


@pytest.mark.spec("G-147", "G-186")
def test_a_gateway_cut_off_from_can1_is_undefined(plain):
    rig = plain().operational()
    rig.gateway.wiring.bus_fault = True
    rig.run(0.03)
    assert rig.system.state is GatewayState.UNDEFINED
    assert rig.gateway.desk.read(2405) == 0


@pytest.mark.spec("G-143", "G-147", "G-144", "G-148")
@pytest.mark.parametrize("unit", ["governor", "gateway"])
@pytest.mark.parametrize("cause", ["bus_fault", "duplicate"])
def test_clearing_helps_only_when_the_bus_is_healthy_again(plain, unit, cause):
    rig = plain().operational()
    faulty = getattr(rig, unit)
    setattr(faulty.wiring, cause, True)
    rig.run(0.3)
    own = faulty.programme.errors.own
    assert own
    faulty.desk.clear_errors()
    assert faulty.programme.errors.own == own
    rig.run(0.1)
    assert faulty.programme.errors.own == own
    setattr(faulty.wiring, cause, False)
    rig.run(0.5)
    faulty.desk.clear_errors()
    rig.run(0.1)
    assert (rig.system.state, rig.word) == (GatewayState.PRE_OPERATIONAL, 0)


@pytest.mark.spec("G-144", "G-148", "G-187", "G-195")
@pytest.mark.parametrize(("unit", "word"), [("governor", 0x0010), ("gateway", 0x0800)])
def test_a_duplicate_number_is_a_communication_error(plain, unit, word):
    rig = plain(NO_HEARTBEAT).operational()
    faulty = getattr(rig, unit)
    faulty.wiring.duplicate = True
    rig.run(0.3)
    assert (rig.system.state, faulty.desk.read(3071)) == (GatewayState.UNDEFINED, 1)
    faulty.wiring.duplicate = False
    assert messages(rig, 0.5) == [BootUp()]
    assert (rig.word, faulty.desk.read(3071)) == (word, 0)
    rig.system.command(OPERATIONAL)
    rig.run(0.05)
    assert rig.word == 0


@pytest.mark.spec("G-195", "G-196")
def test_overflows_of_the_link_are_told_by_device_and_end_in_a_time_out(plain):
    rig = plain({"gateway": {402: 5}, "governor": {401: 5}}).operational()
    rig.run(1.0)
    wiring, desk = rig.gateway.wiring, rig.gateway.desk
    wiring.receive_overflow = True
    rig.run(0.3)
    assert [desk.read(number) for number in range(2401, 2405)] == [0, 1 << 5, 0, 0]
    assert desk.read(3071) == 1
    rig.run(0.4)
    assert [desk.read(number) for number in range(2401, 2405)] == [0, 1 << 5, 1 << 5, 0]
    wiring.receive_overflow, wiring.transmit_overflow, wiring.duplicate = False, True, True
    rig.run(0.7)
    assert [desk.read(number) for number in range(2401, 2405)] == [1 << 5, 0, 0, 1]
    assert rig.governor.desk.read(3071) == 1


@pytest.mark.spec("G-148", "G-189", "G-150", "G-029")
@pytest.mark.parametrize(
    ("buffer", "counter", "word"),
    [(Buffer.CAN1_RECEIVE, 3171, 0x0800), (Buffer.CAN2_RECEIVE, 3173, 0x2000)],
)
def test_a_receive_overflow_begins_anew(plain, buffer, counter, word):
    rig = plain(NO_HEARTBEAT).operational()
    rig.system.overflow(buffer)
    assert rig.system.state is GatewayState.UNDEFINED
    assert messages(rig, 0.5) == [BootUp()]
    assert (rig.system.state, rig.word) == (GatewayState.PRE_OPERATIONAL, word)
    assert (rig.gateway.desk.read(counter), rig.gateway.desk.read(counter - 100)) == (1, 0)
    rig.gateway.desk.clear_errors()
    rig.run(0.05)
    assert rig.word == 0


@pytest.mark.spec("G-150", "G-189")
@pytest.mark.parametrize("command", [OPERATIONAL, MasterCommand.PRE_OPERATIONAL])
def test_an_sdo_transmit_overflow_waits_in_stopped_for_the_master(plain, command):
    rig = plain().operational()
    rig.system.overflow(Buffer.SDO_TRANSMIT)
    assert rig.system.state is GatewayState.STOPPED
    assert messages(rig, 3.0) == []
    assert rig.system.state is GatewayState.STOPPED
    assert rig.word == 0x2000
    rig.system.command(command)
    rig.run(0.05)
    assert rig.word == (0 if command is OPERATIONAL else 0x2000)
    assert rig.system.state is not GatewayState.STOPPED


@pytest.mark.spec("G-149", "G-188", "G-007", "G-026")
@pytest.mark.parametrize(
    ("period", "sign"), [(0, BootUp()), (5000, Heartbeat(GatewayState.PRE_OPERATIONAL))]
)
def test_a_canopen_bus_fault_is_silence_and_then_a_sign_within_half_a_second(plain, period, sign):
    rig = plain({"gateway": {429: period}}).operational()
    rig.run(1.5)
    rig.gateway.plug.fault = True
    assert rig.run(1.2) == []
    assert (rig.system.state, rig.gateway.desk.read(3072)) == (GatewayState.PRE_OPERATIONAL, 1)
    assert rig.gateway.desk.read(12405) == 0
    assert both(rig, 3071) == [0, 0]
    rig.gateway.plug.fault = False
    (_, message), *_ = rig.run(0.5)
    assert message == sign
    assert (rig.word, rig.gateway.desk.read(3072)) == (0x1000, 0)


@pytest.mark.spec("G-149")
def test_initialising_can2_again_is_tried_every_half_second(plain):
    rig = plain(NO_HEARTBEAT).operational()
    for duration in (0.1, 0.6, 1.1):
        rig.gateway.plug.fault = True
        begin = rig.now * 1000
        rig.run(duration)
        rig.gateway.plug.fault = False
        (at, _), *_ = rig.run(0.6)
        tries = 1 + int(duration / 0.5)
        assert tries * 496 <= at - begin <= tries * 496 + 32


@pytest.mark.spec("G-149")
@pytest.mark.parametrize("way", ["operational", "clear"])
def test_a_canopen_bus_fault_stays_visible_until_operational_or_clearing(plain, way):
    rig = plain(NO_HEARTBEAT).operational()
    rig.gateway.plug.fault = True
    rig.run(0.1)
    rig.gateway.desk.clear_errors()
    rig.run(0.1)
    assert rig.word == 0x1000
    rig.gateway.plug.fault = False
    rig.run(0.6)
    if way == "clear":
        rig.gateway.desk.clear_errors()
    else:
        rig.system.command(OPERATIONAL)
    rig.run(0.05)
    assert rig.word == 0


@pytest.mark.spec("G-149")
def test_during_a_canopen_bus_fault_the_master_is_not_heard(plain):
    rig = plain().operational()
    rig.gateway.plug.fault = True
    rig.run(0.1)
    rig.system.command(OPERATIONAL)
    rig.system.receive_rpdo(1, (1, 2, 3))
    assert (rig.system.state, rig.system.listening) == (GatewayState.PRE_OPERATIONAL, False)


@pytest.mark.parametrize(
    ("cause", "register"),
    [
        (lambda rig: None, 0x00),
        (lambda rig: rig.gateway.feed(5.0), 0x05),
        (lambda rig: rig.system.overflow(Buffer.SDO_TRANSMIT), 0x11),
    ],
)
def test_the_error_register_tells_generic_voltage_and_communication(plain, cause, register):
    rig = plain().operational()
    cause(rig)
    rig.run(0.05)
    assert rig.system.error_register == register


@pytest.mark.spec("G-199", "G-200")
def test_who_is_connected_is_shown_by_node(plain):
    desk = plain().on().gateway.desk
    assert [desk.read(number) for number in (2405, 12405, 2410, 2411)] == [1, 1, 0, 2]
    rig = plain({"gateway": {402: 20}, "governor": {401: 20}}).on()
    assert [rig.gateway.desk.read(number) for number in (2410, 2411)] == [1 << 4, 0]
    rig.gateway.desk.connect(node=17, identifier=4711)
    assert [rig.gateway.desk.read(number) for number in (2424, 2425, 3850)] == [2, 0, 4711]


def test_a_bus_fault_is_felt_before_it_is_noticed(rig):
    rig = rig().operational()
    rig.gateway.plug.fault = True
    rig.system.receive_rpdo(2, (7, 8))
    assert rig.system.value(0x2004, 1) == 0


def test_without_an_initialisation_a_healthy_bus_gets_no_sign_of_life(plain):
    rig = plain()
    rig.gateway.plug.fault = True
    rig.gateway.reset()
    rig.run(0.5)
    rig.gateway.plug.fault = False
    assert rig.run(2.0) == []
    assert rig.gateway.desk.read(3072) == 0


@pytest.mark.spec("G-190")
def test_an_init_that_was_under_way_does_not_lead_out_of_a_fatal_error(plain):
    rig = plain().on()
    rig.gateway.fail(3090)
    rig.run(0.05)
    rig.governor.programme.can.send(Command(GovernorCommand.INIT, 50, fresh=False))
    rig.run(0.005)
    assert rig.system.state is GatewayState.UNDEFINED


def test_an_error_in_operational_is_sent_on(plain):
    rig = plain(NO_HEARTBEAT, {"governor": {16460: 0, 16472: 0}}).operational()
    rig.gateway.feed(7.0)
    assert messages(rig, 0.05) == [TpdoFrame(2, (0, 0x20))]
