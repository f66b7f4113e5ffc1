import pytest

from canopen_twins import Bench
from canopen_twins.slave.service import State

from .bus import BOOT_UP, ENTER_PREOP, RESET_COMMUNICATION, RESET_NODE, START, STOP, heard, read


@pytest.fixture
def bench(configured):
    """No CANopen inputs, no heartbeat, no cyclic TPDOs: what is left is easy to see."""
    return configured({16460: 0, 16472: 0}, {429: 0})


@pytest.mark.spec("G-012", "G-013", "G-020", "G-022", "G-026")
def test_it_boots_when_the_governor_has_initialised_it():
    bench = Bench("gateway")
    assert bench.run(0.22) == []
    assert bench.send("601#4000100000000000") == []
    assert bench.send(START) == []
    assert bench.run(0.001) == [BOOT_UP]
    assert str(bench.trace[-1]) == "(0000000000.220625) can0 701#00"
    assert bench.twin.node.state is State.PRE_OPERATIONAL


@pytest.mark.spec("G-018", "G-030", "G-031", "G-032", "G-033", "G-014")
def test_three_states_are_reached_from_each_other_without_a_boot_up(bench):
    for command, state in [
        (START, State.OPERATIONAL),
        (STOP, State.STOPPED),
        (START, State.OPERATIONAL),
        (ENTER_PREOP, State.PRE_OPERATIONAL),
        (STOP, State.STOPPED),
        (ENTER_PREOP, State.PRE_OPERATIONAL),
    ]:
        assert bench.send(command) == []
        assert bench.twin.node.state is state
        assert bench.device.system.state.value.upper() == state
        assert BOOT_UP not in bench.run(0.1)


@pytest.mark.spec("G-018", "G-028", "G-036")
@pytest.mark.parametrize("reset", [RESET_NODE, RESET_COMMUNICATION, "000#8100", "000#8200"])
@pytest.mark.parametrize("state", [START, STOP, ENTER_PREOP])
def test_a_reset_initialises_again_and_is_no_error(bench, reset, state):
    bench.send(state)
    bench.run(0.1)
    assert bench.send(reset) == []
    assert bench.device.system.state.value == "Init"
    assert bench.run(0.1) == [BOOT_UP]
    assert read(bench, 0x2005) == 0


@pytest.mark.spec("G-035")
@pytest.mark.parametrize("command", ["0102", "0202", "8102", "0181", "017F", "01", "0101FF", ""])
def test_commands_to_others_and_malformed_ones_have_no_effect(bench, command):
    bench.send(f"000#{command}")
    assert bench.twin.node.state is State.PRE_OPERATIONAL


@pytest.mark.spec("G-035")
def test_commands_to_all_act(bench):
    bench.send("000#0100")
    assert bench.twin.node.state is State.OPERATIONAL


@pytest.mark.spec("G-018")
@pytest.mark.parametrize("command", ["00", "03", "7F", "83", "FF"])
def test_other_commands_are_none(bench, command):
    bench.send(f"000#{command}01")
    assert bench.twin.node.state is State.PRE_OPERATIONAL


@pytest.mark.spec("G-002")
@pytest.mark.parametrize(
    "frame", ["00000000#0101", "00000601#4000100000000000", "00000201#000000000000"]
)
def test_frames_with_29_bits_have_no_effect(bench, frame):
    assert bench.send(frame) == []
    assert bench.twin.node.state is State.PRE_OPERATIONAL


@pytest.mark.spec("G-002")
def test_identifiers_have_11_bits(bench):
    bench.send(START)
    bench.run(10.0)
    assert bench.trace
    assert [record for record in bench.trace if record.frame.extended] == []


@pytest.mark.spec("G-118", "G-003")
@pytest.mark.parametrize("frame", ["701#R", "181#R", "080#", "100#0000", "7E5#0401000000000000"])
def test_guarding_remote_requests_sync_and_lss_are_not_known(bench, frame):
    bench.send(START)
    bench.run(0.1)
    assert bench.send(frame) == []


@pytest.mark.spec("G-006")
@pytest.mark.parametrize("node_id", [1, 5, 127])
def test_the_node_id_is_parameter_427(configured, node_id):
    by_file, by_setting = configured(gateway={427: node_id}), configured(node_id=node_id)
    for bench in (by_file, by_setting):
        assert bench.sent == [f"{0x700 + node_id:03X}#00"]
        assert bench.device.gateway["CanOpenMyNodeID"] == node_id
        (answer,) = bench.send(f"{0x600 + node_id:03X}#4000180100000000")
        assert answer == f"{0x580 + node_id:03X}#43001801{0x180 + node_id & 0xFF:02X}010000"


@pytest.mark.spec("G-005", "G-006")
def test_another_node_id_acts_after_saving_and_a_reset(bench):
    bench.device.gateway[427] = 9
    bench.device.gateway.save()
    assert bench.device.node_id == 1
    bench.device.gateway.reset()
    assert bench.run(0.3) == ["709#00"]
    assert len(bench.send("609#4000100000000000")) == 1


@pytest.mark.spec("G-110", "G-111", "G-112")
@pytest.mark.parametrize(
    ("time", "period"), [(100, 0.096), (1, 0.016), (1000, 0.992), (65535, 65.52)]
)
def test_heartbeats_come_in_steps_of_16_ms(configured, time, period):
    bench = configured({16460: 0, 16472: 0}, {429: time})
    bench.run(3 * period)
    times = [record.time for record in bench.trace]
    assert times[:3] == pytest.approx([0.220625 + n * period for n in range(3)])
    assert heard(bench.sent, "701")[:3] == ["00", "7F", "7F"]


@pytest.mark.spec("G-110")
def test_without_a_period_there_are_none(bench):
    assert bench.run(60.0) == []


@pytest.mark.spec("G-034", "G-112", "G-015")
def test_heartbeats_tell_the_state_in_three_states(configured):
    bench = configured({16460: 0, 16472: 0, 14401: 0}, {429: 16})
    for command, told in [(START, "05"), (STOP, "04"), (ENTER_PREOP, "7F")]:
        bench.send(command)
        assert bench.run(0.016) == [f"701#{told}"]
    bench.device.governor.reset()
    bench.run(0.1)
    bench.device.gateway.reset()
    assert bench.run(0.1) == []
