import pytest

from canopen_twins.devices.gateway.model.state import GatewayState, MasterCommand

OPERATIONAL = MasterCommand.OPERATIONAL
WATCHING = {"gateway": {428: 127, 430: 100}}


def beat(rig, seconds, period=0.09):
    for _ in range(round(seconds / period)):
        rig.system.partner_heartbeat()
        rig.run(period)


@pytest.mark.spec("G-113", "G-115", "G-146", "G-165", "G-173")
def test_a_partner_that_falls_silent_makes_all_canopen_inputs_faulty(rig):
    rig = rig(WATCHING).operational()
    rig.system.receive_rpdo(1, (0, 0, 0))
    rig.system.receive_rpdo(2, (1, 2))
    beat(rig, 1.0)
    inputs = rig.governor.programme.inputs
    assert (rig.word, rig.governor.desk.read(3005), inputs.active(835)) == (0, 0, True)
    rig.run(0.12)
    assert (rig.word, rig.governor.desk.read(3005), inputs.active(835)) == (0x0200, 1, False)
    assert rig.system.state is GatewayState.OPERATIONAL
    for unit in (rig.governor, rig.gateway):
        assert (unit.desk.read(12420), unit.desk.read(3074)) == (1, 1)


@pytest.mark.spec("G-116", "G-146")
def test_it_clears_itself_when_the_partner_is_back(rig):
    rig = rig(WATCHING).operational()
    rig.system.receive_rpdo(2, (1, 2))
    beat(rig, 0.2)
    rig.run(0.5)
    assert rig.word == 0x0200
    beat(rig, 0.2)
    assert (rig.word, rig.governor.desk.read(3005)) == (0, 0)


@pytest.mark.spec("G-117")
@pytest.mark.parametrize(("silence", "word"), [(0.095, 0), (0.13, 0x0200)])
def test_the_limit_is_a_whole_number_of_gateway_cycles(plain, silence, word):
    rig = plain(WATCHING).operational()
    rig.system.partner_heartbeat()
    rig.run(silence)
    assert rig.word == word


@pytest.mark.spec("G-113")
@pytest.mark.parametrize("off", [{428: 0}, {430: 0}])
def test_it_can_be_switched_off(plain, off):
    rig = plain(WATCHING, {"gateway": off}).operational()
    beat(rig, 0.2)
    rig.run(1.0)
    assert rig.word == 0


@pytest.mark.spec("G-115")
@pytest.mark.parametrize(("always", "word"), [(False, 0), (True, 0x0200)])
def test_a_partner_never_heard_is_missed_on_request_only(plain, always, word):
    rig = plain(WATCHING, always_armed=always).operational()
    rig.run(1.0)
    assert rig.word == word


@pytest.mark.spec("G-115")
def test_silence_outside_operational_is_not_watched(plain):
    rig = plain(WATCHING).operational()
    beat(rig, 0.2)
    rig.system.command(MasterCommand.PRE_OPERATIONAL)
    rig.run(1.0)
    assert rig.word == 0


def test_the_heartbeat_error_stays_outside_operational_until_a_heartbeat_or_operational(plain):
    rig = plain(WATCHING).operational()
    for leave in (
        rig.system.partner_heartbeat,
        rig.gateway.desk.clear_errors,
        lambda: rig.system.command(OPERATIONAL),
    ):
        rig.system.command(OPERATIONAL)
        beat(rig, 0.2)
        rig.run(0.2)
        rig.system.command(MasterCommand.PRE_OPERATIONAL)
        rig.run(0.2)
        assert rig.word == 0x0200
        leave()
        rig.run(0.02)
        assert rig.word == 0


def test_a_heartbeat_is_not_heard_through_a_bus_fault(plain):
    rig = plain(WATCHING).operational()
    beat(rig, 0.2)
    rig.run(0.2)
    rig.gateway.plug.fault = True
    rig.run(0.1)
    rig.system.partner_heartbeat()
    rig.run(0.1)
    assert rig.word == 0x1200
