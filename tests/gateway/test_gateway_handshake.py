import pytest

from canopen_twins.devices.gateway.model.canopen_side import BootUp
from canopen_twins.devices.gateway.model.configuration import ActivePdo, Refusal
from canopen_twins.devices.gateway.model.errors import CanopenError
from canopen_twins.devices.gateway.model.handshake import NEXT, UNDERWAY, Handshake, Phase, Progress
from canopen_twins.devices.gateway.model.heinzmann_can import (
    Command,
    GatewayAlive,
    InitData,
    InitEnd,
    InitReady,
    InitResult,
)
from canopen_twins.devices.gateway.model.parameters import Unit
from canopen_twins.devices.gateway.model.state import GatewayState, GovernorCommand, MasterCommand
from canopen_twins.devices.gateway.model.timing import Time

OWN_IS_PARTNER = {"gateway": {428: 1}}


def attempts(rig):
    """Every attempt is a session; the gateway tells the last one it was in."""
    return rig.governor.programme.handshake.gateway.epoch


def repair(rig):
    rig.gateway.desk.write(428, 0)
    rig.gateway.desk.save()


@pytest.mark.spec("G-024", "G-077", "G-078", "G-141")
def test_three_refusals_end_in_undefined_with_12412_in_both_units(plain):
    rig = plain(OWN_IS_PARTNER)
    rig.system.power_on()
    assert rig.run(3.0) == []
    assert rig.system.state is GatewayState.UNDEFINED
    assert rig.governor.programme.handshake.refusal is Refusal.OWN_IS_PARTNER
    for unit in (rig.gateway, rig.governor):
        assert (unit.desk.read(12412), unit.desk.read(3074)) == (1, 1)
    assert rig.word == 0x0002


@pytest.mark.spec("G-024")
def test_there_are_exactly_three_attempts(plain):
    rig = plain(OWN_IS_PARTNER)
    rig.system.power_on()
    rig.run(3.0)
    assert attempts(rig) == 3


@pytest.mark.spec("G-025", "G-141")
@pytest.mark.parametrize("where", ["gateway", "governor"])
def test_clearing_all_errors_gives_three_more_attempts(plain, where):
    rig = plain(OWN_IS_PARTNER)
    rig.system.power_on()
    rig.run(1.0)
    getattr(rig, where).desk.clear_errors()
    rig.run(0.002)
    assert rig.governor.desk.read(12412) == 0
    rig.run(1.0)
    assert attempts(rig) == 6
    assert rig.governor.desk.read(12412) == 1


@pytest.mark.spec("G-025", "G-141")
def test_a_repaired_gateway_is_initialised_after_its_reset(plain):
    rig = plain(OWN_IS_PARTNER)
    rig.system.power_on()
    rig.run(1.0)
    repair(rig)
    rig.gateway.reset()
    assert [message for _, message in rig.run(0.3)] == [BootUp()]


@pytest.mark.spec("G-054", "G-141", "G-152")
@pytest.mark.parametrize(
    "end",
    [
        lambda rig: rig.system.command(MasterCommand.OPERATIONAL),
        lambda rig: rig.governor.desk.clear_errors(),
    ],
)
def test_12412_is_told_in_preoperational_until_operational_or_until_it_is_cleared(plain, end):
    rig = plain(OWN_IS_PARTNER)
    rig.system.power_on()
    rig.run(1.0)
    repair(rig)
    rig.gateway.reset()
    rig.run(0.3)
    assert (rig.system.state, rig.word) == (GatewayState.PRE_OPERATIONAL, 0x0102)
    end(rig)
    rig.run(0.1)
    assert rig.word == 0


@pytest.mark.spec("G-025", "G-141")
def test_a_gateway_that_has_never_heard_its_governor_is_initialised_after_its_reset(plain):
    rig = plain()
    rig.system.link.to[Unit.GATEWAY].cut = True
    rig.system.power_on()
    rig.run(1.25)
    rig.system.link.to[Unit.GATEWAY].cut = False
    assert rig.run(2.0) == []
    rig.gateway.reset()
    assert [message for _, message in rig.run(0.3)] == [BootUp()]


@pytest.mark.spec("G-027")
def test_a_lost_init_telegram_costs_one_attempt(plain):
    rig = plain()
    rig.system.power_on()
    rig.run(0.217)  # Init is ordered, its confirmation is on the way back
    rig.system.link.to[Unit.GATEWAY].drop = 1
    rig.run(0.01)
    assert rig.governor.programme.handshake.refusal is Refusal.STRUCTURE
    assert [message for _, message in rig.run(0.2)] == [BootUp()]


@pytest.mark.spec("G-027")
def test_a_lost_answer_costs_the_time_of_one_step(plain):
    rig = plain()
    rig.system.power_on()
    rig.run(0.2165)
    rig.system.link.to[Unit.GOVERNOR].drop = 1
    assert rig.run(0.3) == []
    assert [message for _, message in rig.run(0.4)] == [BootUp()]


def test_a_telegram_of_another_session_is_ignored(plain):
    rig = plain(OWN_IS_PARTNER)
    rig.system.power_on()
    rig.run(0.3)
    governor = rig.governor.programme.can
    governor.send(InitEnd(99, 0))
    governor.send(Command(GovernorCommand.PRE_OPERATIONAL, 99, fresh=False))
    rig.run(0.002)
    assert rig.system.state is GatewayState.INIT


def test_init_data_of_another_session_do_not_spoil_this_one(plain):
    rig = plain()
    rig.system.power_on()
    rig.run(0.21675)
    assert rig.system.state is GatewayState.INIT
    rig.governor.programme.can.send(InitData(99, (ActivePdo(True, 1, ()),)))
    assert [message for _, message in rig.run(0.01)] == [BootUp()]


def test_answers_of_another_session_lead_nowhere():
    sent = []
    handshake = Handshake(Time(), sent.append, [])
    handshake.heard(GatewayAlive(GatewayState.UNDEFINED, 7, True, True, CanopenError(0)))
    handshake.step()
    handshake.ready(InitReady(7))
    assert handshake.phase is Phase.READY
    handshake.ready(InitReady(8))
    handshake.judged(InitResult(7, None))
    assert handshake.phase is Phase.RESULT
    handshake.judged(InitResult(8, None))
    assert handshake.phase is Phase.PREOP
    orders = [body.command for body in sent if isinstance(body, Command)]
    assert orders == [GovernorCommand.INIT, GovernorCommand.PRE_OPERATIONAL]


@pytest.mark.parametrize("phase", Phase)
def test_every_phase_can_be_left(phase):
    assert set(NEXT[phase].values()) - {phase}


@pytest.mark.parametrize("phase", UNDERWAY)
def test_every_step_can_fail(phase):
    assert NEXT[phase][Progress.FAILED] is Phase.PAUSE
    assert NEXT[phase][Progress.GIVEN_UP] is Phase.FAILED


@pytest.mark.spec("G-201")
@pytest.mark.parametrize(
    ("unit", "number"),
    [
        ("gateway", 401),
        ("gateway", 402),
        ("governor", 401),
        ("governor", 403),
    ],
)
def test_node_numbers_that_do_not_match_crosswise_give_no_link(plain, unit, number):
    rig = plain({unit: {number: 9}})
    rig.system.power_on()
    assert rig.run(2.0) == []
    assert rig.system.state is GatewayState.UNDEFINED
    assert (rig.gateway.desk.read(3071), rig.governor.desk.read(3071)) == (1, 1)


@pytest.mark.spec("G-201")
@pytest.mark.parametrize(("unit", "number"), [("gateway", 4400), ("governor", 4406)])
def test_a_link_that_is_not_activated_stays_silent_without_an_error_there(plain, unit, number):
    rig = plain({unit: {number: 0}})
    rig.system.power_on()
    assert rig.run(2.0) == []
    assert rig.system.state is GatewayState.UNDEFINED
    assert getattr(rig, unit).desk.read(3071) == 0


@pytest.mark.spec("G-001", "G-186")
def test_different_bit_rates_are_a_bus_error_in_both_units(plain):
    rig = plain({"gateway": {416: 500}})
    rig.system.power_on()
    assert rig.run(1.0) == []
    assert (rig.gateway.desk.read(3070), rig.governor.desk.read(3070)) == (1, 1)
    rig.governor.power_off()
    rig.run(0.1)
    assert rig.gateway.desk.read(3070) == 0
    rig.governor.reset()
    rig.run(0.3)
    assert rig.gateway.desk.read(3070) == 1
    rig.governor.desk.write(416, 500)
    rig.governor.desk.save()
    rig.governor.reset()
    assert BootUp() in [message for _, message in rig.run(1.0)]


@pytest.mark.spec("G-001")
def test_bit_rates_set_by_hand_are_not_compared(plain):
    rig = plain({"gateway": {416: 500, 4416: 1}}).on()
    assert rig.system.state is GatewayState.PRE_OPERATIONAL


@pytest.mark.spec("G-001")
@pytest.mark.parametrize("rate", [125, 250, 500, 1000])
def test_the_bit_rate_of_canopen_is_its_own(plain, rate):
    rig = plain({"gateway": {426: rate}}).on()
    assert rig.system.state is GatewayState.PRE_OPERATIONAL
    assert rig.gateway.desk.read(416) == 250
