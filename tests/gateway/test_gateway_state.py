import pytest

from canopen_twins.devices.gateway.model.canopen_side import BootUp
from canopen_twins.devices.gateway.model.state import (
    COMMUNICATING,
    NEXT,
    GatewayState,
    GovernorCommand,
    MasterCommand,
    Trouble,
    state_word,
)

MASTER = {
    GatewayState.PRE_OPERATIONAL: {
        MasterCommand.OPERATIONAL: GatewayState.OPERATIONAL,
        MasterCommand.STOP: GatewayState.STOPPED,
    },
    GatewayState.OPERATIONAL: {
        MasterCommand.PRE_OPERATIONAL: GatewayState.PRE_OPERATIONAL,
        MasterCommand.STOP: GatewayState.STOPPED,
    },
    GatewayState.STOPPED: {
        MasterCommand.PRE_OPERATIONAL: GatewayState.PRE_OPERATIONAL,
        MasterCommand.OPERATIONAL: GatewayState.OPERATIONAL,
    },
}


@pytest.mark.spec("G-010", "G-016")
@pytest.mark.parametrize("state", GatewayState)
@pytest.mark.parametrize("command", MasterCommand)
def test_the_master_is_heard_in_three_of_five_states(state, command):
    reset = command in (MasterCommand.RESET_NODE, MasterCommand.RESET_COMMUNICATION)
    expected = GatewayState.INIT if reset else MASTER.get(state, {}).get(command, state)
    assert NEXT[state].get(command, state) is (expected if state in COMMUNICATING else state)


@pytest.mark.spec("G-017")
@pytest.mark.parametrize("state", GatewayState)
def test_the_governor_leads_to_three_states_only(state):
    reached = {NEXT[state].get(command, state) for command in GovernorCommand}
    assert reached <= {
        GatewayState.UNDEFINED,
        GatewayState.INIT,
        GatewayState.PRE_OPERATIONAL,
        state,
    }


@pytest.mark.spec("G-019")
def test_only_the_governor_leads_out_of_init_to_pre_operational():
    leading = [
        each for each, to in NEXT[GatewayState.INIT].items() if to is GatewayState.PRE_OPERATIONAL
    ]
    assert leading == [GovernorCommand.PRE_OPERATIONAL]


@pytest.mark.parametrize("state", GatewayState)
def test_trouble_can_end_every_state(state):
    assert NEXT[state][Trouble.ABORT] is GatewayState.UNDEFINED
    assert NEXT[state][GovernorCommand.UNDEFINED] is GatewayState.UNDEFINED


@pytest.mark.spec("G-011")
@pytest.mark.parametrize("unit", ["gateway", "governor"])
def test_the_state_is_shown_by_one_of_four_bits(plain, unit):
    rig = plain()
    desk = getattr(rig, unit).desk
    numbers = range(12401, 12405)
    rig.system.power_on()
    rig.run(0.21)
    assert [desk.read(number) for number in numbers] == [0, 0, 0, 0]
    rig.run(0.04)
    assert [desk.read(number) for number in numbers] == [0, 0, 1, 0]
    rig.system.command(MasterCommand.OPERATIONAL)
    rig.run(0.002)
    assert [desk.read(number) for number in numbers] == [0, 0, 0, 1]
    rig.system.command(MasterCommand.STOP)
    rig.run(0.002)
    assert [desk.read(number) for number in numbers] == [1, 0, 0, 0]
    assert desk.read(12400) == 1


def test_the_state_word_has_the_bits_of_the_state_parameters():
    words = {state: state_word(state) for state in GatewayState}
    assert list(words.values()) == [0, 2, 4, 8, 1]


@pytest.mark.spec("G-020", "G-021", "G-022", "G-026", "G-132")
def test_power_up_ends_in_pre_operational_with_one_boot_up(plain):
    rig = plain()
    rig.system.power_on()
    assert rig.run(0.22) == []
    assert rig.run(0.7) == [(220.625, BootUp())]
    assert rig.system.state is GatewayState.PRE_OPERATIONAL
    assert rig.word == 0


@pytest.mark.spec("G-012", "G-013", "G-016", "G-023")
def test_before_pre_operational_nothing_is_heard_and_there_is_no_dictionary(plain):
    rig = plain()
    rig.system.power_on()
    rig.run(0.2175)
    assert rig.system.state is GatewayState.INIT
    assert not rig.system.listening
    assert rig.system.dictionary is None
    for command in MasterCommand:
        rig.system.command(command)
    assert rig.system.state is GatewayState.INIT


@pytest.mark.spec("G-028", "G-036")
@pytest.mark.parametrize("command", [MasterCommand.RESET_NODE, MasterCommand.RESET_COMMUNICATION])
@pytest.mark.parametrize("before", [None, MasterCommand.OPERATIONAL, MasterCommand.STOP])
def test_a_reset_by_the_master_initialises_again_without_an_error(plain, command, before):
    rig = plain({"gateway": {429: 0}}).on()
    if before:
        rig.system.command(before)
    rig.system.command(command)
    assert rig.system.state is GatewayState.INIT
    assert [message for _, message in rig.run(0.05)] == [BootUp()]
    assert rig.system.state is GatewayState.PRE_OPERATIONAL
    assert (rig.word, rig.gateway.desk.read(3074)) == (0, 0)


@pytest.mark.spec("G-019")
def test_without_the_governor_init_is_never_left(plain):
    rig = plain().on()
    for direction in rig.system.link.to.values():
        direction.cut = True
    rig.system.command(MasterCommand.RESET_NODE)
    rig.run(0.45)
    assert rig.system.state is GatewayState.INIT
