import pytest

from canopen_twins.slave.service import State

READ = "605#4000100000000000"
START, STOP, PRE_OPERATIONAL = "000#0105", "000#0205", "000#8005"
RESET_NODE, RESET_COMMUNICATION = "000#8105", "000#8205"
STATES = {
    "705#7F": PRE_OPERATIONAL,
    "705#05": START,
    "705#04": STOP,
}


@pytest.fixture
def beating(bench):
    """Sends its state every 100 ms, until it is reset."""
    bench.send("605#2B17100064000000")
    return bench


def beat(bench):
    return [frame for frame in bench.run(0.1) if frame.startswith("705")]


@pytest.mark.spec("T-010")
def test_after_power_on_the_node_is_pre_operational_by_itself(beating):
    assert beating.twin.node.state is State.PRE_OPERATIONAL
    assert beating.send(READ) == ["585#4300100000000000"]
    assert beat(beating) == ["705#7F"]


@pytest.mark.spec("T-017")
@pytest.mark.parametrize("before", STATES.values())
@pytest.mark.parametrize("shown", STATES)
def test_every_state_is_reached_from_every_other(beating, before, shown):
    beating.send(before)
    beating.send(STATES[shown])
    assert beat(beating) == [shown]


@pytest.mark.spec("T-014", "T-017")
@pytest.mark.parametrize("before", STATES.values())
@pytest.mark.parametrize("reset", [RESET_NODE, RESET_COMMUNICATION])
def test_a_reset_from_every_state_ends_in_a_boot_up_and_pre_operational(bench, before, reset):
    bench.send(before)
    assert bench.send(reset) == ["705#00"]
    assert bench.twin.node.state is State.PRE_OPERATIONAL
    assert bench.run(10.0) == []


@pytest.mark.spec("T-014")
def test_no_other_change_of_state_sends_a_boot_up(bench):
    for command in (START, PRE_OPERATIONAL, STOP, PRE_OPERATIONAL, STOP, START):
        assert "705#00" not in bench.send(command)


@pytest.mark.spec("T-013")
def test_node_id_0_means_all(bench):
    bench.send("000#0100")
    assert bench.twin.node.state is State.OPERATIONAL
    assert bench.send("000#8200") == ["705#00"]


@pytest.mark.spec("T-013")
@pytest.mark.parametrize(
    "frame",
    [
        "000#0106",  # another node
        "000#0185",
        "000#0005",  # no command
        "000#0305",
        "000#5005",
        "000#FF05",
        "000#",  # no length
        "000#01",
        "000#010500",
        "000#0105000000000000",
        "000#R",  # no command at all
        "00000000#0105",
        "001#0105",
    ],
)
def test_what_is_no_command_for_this_node_changes_nothing(beating, frame):
    assert beating.send(frame) == []
    assert beating.send(READ) == ["585#4300100000000000"]
    assert beat(beating) == ["705#7F"]


def test_the_profile_says_which_lengths_are_obeyed(bench_of):
    bench = bench_of(nmt_lengths=range(2, 9))
    for frame in ("000#", "000#01", "000#0205000000000000"):
        bench.send(frame)
    assert bench.twin.node.state is State.STOPPED


@pytest.mark.spec("T-016")
def test_stopped_knows_nothing_but_nmt_and_heartbeat(beating):
    beating.send(STOP)
    for frame in (READ, "080#", "205#010203", "285#R", "185#R"):
        assert beating.send(frame) == []
    beating.inject("error", code=0x2310)
    assert beating.run(0.3) == ["705#04"] * 3
    assert beating.device.level == 0


@pytest.mark.spec("T-015")
@pytest.mark.parametrize("state", [PRE_OPERATIONAL, STOP])
def test_pdos_work_in_operational_only(operational, state):
    operational.send(state)
    for frame in ("205#010203", "305#01020304", "080#", "185#R", "285#R"):
        assert operational.send(frame) == []
    operational.inject("level", value=3)
    assert operational.run(1.0) == []
    operational.send(START)
    assert operational.sdo["Byte"].raw == 0
    assert operational.sdo["Double word"].raw == 0


@pytest.mark.spec("T-013")
def test_the_same_command_again_changes_nothing(operational):
    assert operational.send(START) == []
    assert operational.device.told.count("OPERATIONAL") == 1


def test_the_device_is_told_of_every_state(bench):
    start = len(bench.device.told)
    for command in (START, STOP, PRE_OPERATIONAL, RESET_COMMUNICATION):
        bench.send(command)
    assert bench.device.told[start:] == [
        "OPERATIONAL",
        "STOPPED",
        "PRE-OPERATIONAL",
        "INITIALISING",
        "reset communication",
        "PRE-OPERATIONAL",
    ]


def test_an_ordinary_master_starts_a_node(bench):
    heard = []
    bench.master.subscribe(0x705, lambda can_id, data, timestamp: heard.append(bytes(data)))
    bench.twin.remote.nmt.state = "RESET"
    assert heard == [b"\0"]
    bench.twin.remote.nmt.state = "OPERATIONAL"
    assert bench.twin.node.state is State.OPERATIONAL


@pytest.mark.parametrize("state", [State.STOPPED, State.PRE_OPERATIONAL, State.OPERATIONAL])
def test_a_device_may_enter_a_state_by_itself(beating, state):
    other = START if state is State.STOPPED else STOP
    beating.send(other)
    with beating.twin.node.acting() as probe:
        probe.nmt_state = state
    assert beating.twin.node.state is state
    assert probe.told[-1] == state
    assert (
        STATES[beat(beating)[0]]
        == {"STOPPED": STOP, "PRE-OPERATIONAL": PRE_OPERATIONAL, "OPERATIONAL": START}[state]
    )


def test_while_a_device_insists_on_a_state_the_master_changes_nothing(beating):
    with beating.twin.node.acting() as probe:
        probe.nmt_state = State.STOPPED
    beating.send(START)
    assert beating.twin.node.state is State.STOPPED
    with beating.twin.node.acting() as probe:
        probe.nmt_state = None
    assert beating.twin.node.state is State.STOPPED
    beating.send(START)
    assert beating.twin.node.state is State.OPERATIONAL
