import pytest

from canopen_twins.devices.gateway.model.canopen_side import BootUp, TpdoFrame
from canopen_twins.devices.gateway.model.heinzmann_can import GovernorAlive
from canopen_twins.devices.gateway.model.parameters import Unit
from canopen_twins.devices.gateway.model.state import GatewayState, MasterCommand
from canopen_twins.devices.gateway.model.timing import NEVER

NO_HEARTBEAT = {"gateway": {429: 0}}


def kinds(sent):
    return list(dict.fromkeys(type(message) for _, message in sent))


def cut(rig, *towards, seconds):
    for unit in towards:
        rig.system.link.to[unit].cut = True
    sent = rig.run(seconds)
    for unit in towards:
        rig.system.link.to[unit].cut = False
    return sent


@pytest.mark.spec("G-130", "G-134", "G-140", "G-152", "G-029", "G-151")
def test_a_governor_reset_in_operational_boots_again_with_12411(plain):
    rig = plain(NO_HEARTBEAT).operational()
    rig.governor.reset()
    sent = rig.run(0.3)
    assert [message for _, message in sent if isinstance(message, BootUp)] == [BootUp()]
    assert sent[-1][1] == BootUp()
    assert rig.system.state is GatewayState.PRE_OPERATIONAL
    rig.run(2.0)
    assert rig.word == 0x0001
    for unit in (rig.governor, rig.gateway):
        assert (unit.desk.read(12411), unit.desk.read(3074)) == (1, 1)


@pytest.mark.spec("G-131", "G-134", "G-145", "G-152", "G-029")
def test_a_gateway_reset_in_operational_boots_again_with_12419(plain):
    rig = plain(NO_HEARTBEAT).operational()
    rig.gateway.reset()
    assert rig.run(0.2) == []
    assert [message for _, message in rig.run(0.1)] == [BootUp()]
    rig.run(2.0)
    assert rig.word == 0x0100
    for unit in (rig.governor, rig.gateway):
        assert (unit.desk.read(12419), unit.desk.read(3074)) == (1, 1)


@pytest.mark.spec("G-132")
def test_a_reset_of_both_is_a_normal_power_up(plain):
    rig = plain(NO_HEARTBEAT).operational()
    rig.governor.reset()
    rig.gateway.reset()
    assert [message for _, message in rig.run(1.0)] == [BootUp()]
    assert rig.word == 0


@pytest.mark.spec("G-133")
@pytest.mark.parametrize("unit", ["governor", "gateway"])
def test_pdos_resume_only_after_the_master_says_so(plain, unit):
    rig = plain(NO_HEARTBEAT).operational()
    getattr(rig, unit).reset()
    rig.run(0.3)
    assert rig.run(1.0) == []
    rig.system.command(MasterCommand.OPERATIONAL)
    assert kinds(rig.run(0.1)) == [TpdoFrame]


@pytest.mark.spec("G-140", "G-145")
@pytest.mark.parametrize("unit", ["governor", "gateway"])
@pytest.mark.parametrize("way", ["operational", "clear"])
def test_a_reset_error_is_cleared_by_operational_or_by_clearing(plain, unit, way):
    rig = plain().operational()
    getattr(rig, unit).reset()
    rig.run(0.5)
    assert rig.word
    if way == "clear":
        rig.governor.desk.clear_errors()
    else:
        rig.system.command(MasterCommand.OPERATIONAL)
    rig.run(0.05)
    assert rig.word == 0
    assert (rig.governor.desk.read(3074), rig.gateway.desk.read(3074)) == (0, 0)


@pytest.mark.spec("G-140")
def test_the_stale_operational_before_the_new_init_clears_nothing(plain):
    rig = plain().operational()
    rig.governor.reset()
    rig.run(0.201)
    while not rig.governor.desk.read(12411):
        rig.run(0.001)
    assert rig.system.state is GatewayState.OPERATIONAL
    rig.run(0.1)
    assert (rig.system.state, rig.word) == (GatewayState.PRE_OPERATIONAL, 0x0001)


@pytest.mark.spec("G-198", "G-187", "G-148")
def test_a_governor_that_is_late_is_missed_after_the_start_delay(plain):
    rig = plain(NO_HEARTBEAT)
    rig.gateway.reset()
    assert rig.run(1.19) == []
    assert rig.gateway.desk.read(3071) == 0
    assert rig.run(3.81) == []
    assert (rig.gateway.desk.read(3071), rig.gateway.desk.read(12422)) == (1, 1)
    assert rig.gateway.desk.read(2403) == 2
    rig.governor.reset()
    assert [message for _, message in rig.run(1.0)] == [BootUp()]
    assert (rig.word, rig.gateway.desk.read(3071)) == (0x0800, 0)
    rig.system.command(MasterCommand.OPERATIONAL)
    rig.run(0.05)
    assert rig.word == 0


@pytest.mark.spec("G-198")
@pytest.mark.parametrize("delay", [0.0, 3.0])
def test_the_start_delay_is_a_parameter(plain, delay):
    rig = plain({"gateway": {400: delay}})
    rig.gateway.reset()
    rig.run(0.2 + max(0.5, delay))
    assert rig.gateway.desk.read(3071) == 0
    rig.run(0.05)
    assert rig.gateway.desk.read(3071) == 1


def test_a_short_interruption_of_the_link_only_costs_telegrams(plain):
    rig = plain(NO_HEARTBEAT).operational()
    rig.run(1.5)
    assert cut(rig, *Unit, seconds=0.3)[1:] == []
    assert rig.system.state is GatewayState.OPERATIONAL
    assert kinds(rig.run(0.1)) == [TpdoFrame]
    assert rig.word == 0


@pytest.mark.spec("G-029", "G-144", "G-148", "G-152", "G-187")
def test_a_long_interruption_is_noticed_by_both_and_got_over(plain):
    rig = plain(NO_HEARTBEAT).operational()
    rig.run(1.5)
    cut(rig, *Unit, seconds=1.5)
    assert rig.system.state is GatewayState.UNDEFINED
    assert [message for _, message in rig.run(0.3)] == [BootUp()]
    assert rig.word == 0x0810
    assert (rig.governor.desk.read(3071), rig.gateway.desk.read(3071)) == (0, 0)


@pytest.mark.spec("G-144", "G-148")
@pytest.mark.parametrize(("towards", "word"), [(Unit.GATEWAY, 0x0800), (Unit.GOVERNOR, 0x0010)])
def test_an_interruption_of_one_direction_is_noticed_by_the_one_that_hears_nothing(
    plain, towards, word
):
    rig = plain(NO_HEARTBEAT).operational()
    rig.run(1.5)
    cut(rig, towards, seconds=1.5)
    assert rig.system.state is GatewayState.UNDEFINED
    assert [message for _, message in rig.run(0.3)] == [BootUp()]
    assert rig.word == word


@pytest.mark.spec("G-197")
def test_to_a_silent_partner_the_governor_sends_less(plain):
    rig = plain().operational()
    rig.system.link.to[Unit.GOVERNOR].cut = True
    rig.run(1.5)
    sent = []
    for _ in range(1000):
        rig.run(0.00025)
        sent += [telegram.body for _, telegram in rig.system.link.to[Unit.GATEWAY]._underway]
    assert {type(body) for body in sent} == {GovernorAlive}


def test_a_slower_link_delays_the_boot_up(plain):
    rig = plain()
    for direction in rig.system.link.to.values():
        direction.delay = 10_000
    rig.system.power_on()
    ((at, _),) = rig.run(0.5)
    assert at == 215.625 + 5 * 10  # five telegrams, beginning with Init


def test_a_slow_link_leads_to_one_boot_up(plain):
    rig = plain(NO_HEARTBEAT)
    for direction in rig.system.link.to.values():
        direction.delay = 80_000
    rig.system.power_on()
    assert [message for _, message in rig.run(3.0)] == [BootUp()]
    assert rig.word == 0


def test_telegrams_of_the_moment_come_before_the_main_cycle(plain):
    rig = plain()
    to_gateway = rig.system.link.to[Unit.GATEWAY]
    to_gateway.delay = 16_000
    rig.system.power_on()
    rig.run(1.69)
    to_gateway.cut = True  # what is sent last arrives at 1700.375 ms
    rig.run(0.505)
    to_gateway.cut = False  # what is sent next arrives at 2216 ms, with a main cycle of the gateway
    rig.run(0.1)
    assert rig.word == 0


def test_telegrams_do_not_overtake_each_other(plain):
    rig = plain().operational()
    direction = rig.system.link.to[Unit.GATEWAY]
    direction.delay = 100_000
    rig.run(0.05)
    direction.delay = 125
    times = []
    rig.run(0.02)
    while direction.due < NEVER:
        times.append(direction.due)
        direction.arrive()
    assert times == sorted(times)


@pytest.mark.spec("G-008")
def test_a_big_step_is_as_good_as_many_small_ones(rig):
    big, small = rig().operational(), rig().operational()
    big.system.step(3.0)
    for _ in range(24000):
        small.system.step(0.000125)
    assert big.system.outbox == small.system.outbox
    assert big.governor.engine.speed == small.governor.engine.speed


@pytest.mark.spec("G-140")
def test_what_the_gateway_said_before_the_new_session_clears_nothing(plain):
    rig = plain(NO_HEARTBEAT)
    for direction in rig.system.link.to.values():
        direction.delay = 50_000  # there and back: something old is always on its way
    rig.system.power_on()
    rig.run(0.7)
    rig.system.command(MasterCommand.OPERATIONAL)
    rig.run(0.1)
    assert rig.system.state is GatewayState.OPERATIONAL
    rig.governor.reset()
    rig.run(1.0)
    assert (rig.system.state, rig.word) == (GatewayState.PRE_OPERATIONAL, 0x0001)


def test_the_same_story_gives_the_same_messages(rig):
    def story():
        each = rig().operational()
        each.governor.reset()
        return each.run(2.0)

    assert story() == story()


def test_without_power_nothing_is_due(plain):
    rig = plain().operational()
    rig.system.power_off()
    rig.run(0.01)
    assert rig.system.rest == float("inf")
    assert (rig.system.state, rig.system.listening) == (GatewayState.UNDEFINED, False)
    assert rig.system.dictionary is None
