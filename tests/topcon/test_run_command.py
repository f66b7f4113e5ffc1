import pytest

from canopen_twins import Bench

from .bus import RESET_NODE, START, refused, run, state_of_output

OFF, CV, CC, CP = 0x0000, 0x0003, 0x0005, 0x0009
WARNING, ERROR = 1 << 14, 1 << 15


def command(bench, value=None):
    if value is not None:
        bench.sdo["Run command"].raw = value
    return bench.sdo["Run command"].raw


@pytest.fixture
def running(topcon):
    """At 200 V, with 20 A into a resistor."""
    topcon.set(load="resistor 10")
    run(topcon, voltage=2000)
    topcon.run(1.0)
    return topcon


@pytest.mark.spec("T-175", "T-178", "T-180")
def test_1_enables_the_output_and_0_disables_it(topcon):
    topcon.sdo["Voltage reference"].raw = 2000
    topcon.sdo["Current reference"].raw = 4000
    topcon.run(1.0)
    assert topcon.sdo["Actual voltage"].raw == 0
    command(topcon, 1)
    topcon.run(1.0)
    assert (state_of_output(topcon), topcon.sdo["Actual voltage"].raw) == (CV, 2000)
    command(topcon, 0)
    assert state_of_output(topcon) == OFF
    topcon.run(10.0)
    assert topcon.sdo["Actual voltage"].raw == 0


@pytest.mark.spec("T-176", "A-48", "A-46")
def test_2_resets_the_error_and_starts_nothing(running):
    running.inject("error", number=0x23)
    assert state_of_output(running) == ERROR
    assert command(running) == 1
    command(running, 2)
    running.run(1.0)
    assert state_of_output(running) == OFF
    command(running, 1)
    assert state_of_output(running) == CV


@pytest.mark.spec("A-48", "A-47")
def test_every_write_of_1_is_a_command(running):
    running.send(START)
    running.inject("error", number=0x23)
    for _ in range(3):
        running.send("505#0100")
        assert state_of_output(running) == ERROR
    running.send("505#0200")
    assert state_of_output(running) == OFF
    running.send("505#0100")
    assert state_of_output(running) == CV


@pytest.mark.spec("T-177", "A-45")
def test_other_commands_are_refused_and_change_nothing(running):
    for value in [*range(3, 256), 0x0100, 0x8001, 0xFFFF]:
        with refused(0x06090030):
            command(running, value)
    assert command(running) == 1
    assert state_of_output(running) == CV


@pytest.mark.spec("A-46")
def test_it_reads_back_as_the_last_command_taken_not_as_the_state(topcon):
    assert command(topcon) == 0
    for value in (1, 2, 0, 2):
        assert command(topcon, value) == value
    command(topcon, 1)
    topcon.inject("error", number=0x23)
    assert (command(topcon), state_of_output(topcon)) == (1, ERROR)
    topcon.send(RESET_NODE)
    assert command(topcon) == 0


@pytest.mark.spec("A-49")
def test_a_reset_without_an_error_leaves_the_output_on(running):
    command(running, 2)
    running.run(1.0)
    assert (state_of_output(running), running.sdo["Actual voltage"].raw) == (CV, 2000)


@pytest.mark.spec("A-80")
def test_running_again_starts_no_new_ramp(running):
    command(running, 1)
    running.run(0.001)
    assert running.sdo["Actual voltage"].raw == 2000


@pytest.mark.spec("A-46", "A-48")
def test_a_trip_leaves_the_set_values_as_they_are(running):
    running.inject("error", number=0x23)
    assert [running.sdo[index].raw for index in range(0x2010, 0x2015)] == [2000, 4000, 4000, 0, 1]


@pytest.mark.spec("T-180", "A-52")
@pytest.mark.parametrize(
    ("parts", "word"),
    [
        ((2000, 4000, 4000, 0), CV),
        ((2000, 400, 4000, 0), CC),
        ((2000, 4000, 100, 0), CP),
        ((2000, 4000, 4000, 4000), CV),
    ],
    ids=["voltage", "current", "power", "resistance"],
)
def test_one_bit_says_which_limit_holds_the_output(topcon, parts, word):
    topcon.set(load="resistor 10")
    run(topcon, *parts)
    topcon.run(3.0)
    assert state_of_output(topcon) == word
    command(topcon, 0)
    assert state_of_output(topcon) == OFF


@pytest.mark.spec("T-180", "A-53")
def test_a_warning_is_bit_14_and_nothing_else(running):
    sent = len(running.sent)
    running.inject("warning")
    assert state_of_output(running) == CV | WARNING
    assert running.sdo["Error Register"].raw == 0
    assert running.sdo["Pre-defined Error Field"][0].raw == 0
    running.run(10.0)
    assert state_of_output(running) == CV | WARNING  # latched
    assert all(frame.startswith("585") for frame in running.sent[sent:])
    command(running, 0)
    assert state_of_output(running) == WARNING
    command(running, 2)
    assert state_of_output(running) == OFF


@pytest.mark.spec("A-53")
def test_a_warning_whose_cause_is_there_comes_back_at_once():
    bench = Bench("topcon", ambient=85)
    bench.run(0.01)
    command(bench, 2)
    assert state_of_output(bench) == WARNING
    bench.set(ambient=25)
    bench.run(1000)
    assert state_of_output(bench) == WARNING
    command(bench, 2)
    assert state_of_output(bench) == OFF


@pytest.mark.spec("T-180", "A-53")
def test_error_and_warning_stand_beside_each_other(running):
    running.inject("warning")
    running.inject("error", number=0x23)
    assert state_of_output(running) == ERROR | WARNING


@pytest.mark.spec("T-180", "A-63")
def test_an_error_of_the_card_is_not_bit_15(running):
    running.inject("card_error", code=0x8110)
    assert state_of_output(running) == CV
