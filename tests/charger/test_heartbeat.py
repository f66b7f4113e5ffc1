import pytest
from charger_bus import ENTER_PREOP, START, STOP, aborted, ask, refused

from canopen_twins import Bench


@pytest.mark.spec("C-024", "A-01")
def test_as_delivered_it_beats_once_a_second(bench):
    assert bench.sdo[0x1017].raw == 1000
    assert bench.run(0.9) == []
    assert bench.run(3.1) == ["763#7F"] * 4


@pytest.mark.spec("C-024", "A-01")
def test_what_it_is_delivered_with_can_be_chosen():
    bench = Bench("charger", heartbeat_default_ms=0)
    assert bench.sdo[0x1017].raw == 0
    assert bench.run(5.0) == []


@pytest.mark.spec("C-021", "C-026")
@pytest.mark.parametrize(
    ("command", "beat"), [(START, "763#05"), (STOP, "763#04"), (ENTER_PREOP, "763#7F")]
)
def test_a_beat_is_one_byte_with_the_state(bench, command, beat):
    bench.sdo[0x2002][0x01].raw = 60_000
    bench.send(command)
    assert bench.run(2.5) == [beat] * 2


@pytest.mark.spec("C-022", "C-026")
@pytest.mark.parametrize("state", [START, ENTER_PREOP])
@pytest.mark.parametrize("milliseconds", [100, 200, 5000, 60_000])
def test_a_new_period_acts_at_once(bench, state, milliseconds):
    bench.sdo[0x2002][0x01].raw = 60_000
    bench.send(state)
    bench.run(0.55)
    bench.sdo[0x1017].raw = milliseconds
    beats = [bench.run(milliseconds / 1000 - 0.01), bench.run(0.02)]
    assert [sum(f.startswith("763#") for f in frames) for frames in beats] == [0, 1]


@pytest.mark.spec("C-023")
def test_0_switches_it_off(bench):
    bench.sdo[0x1017].raw = 0
    assert bench.sdo[0x1017].raw == 0
    assert bench.run(120.0) == []


@pytest.mark.spec("C-025", "A-02")
@pytest.mark.parametrize(
    ("milliseconds", "code"),
    [
        (1, 0x06090032),
        (50, 0x06090032),
        (99, 0x06090032),
        (150, 0x06090030),
        (59_999, 0x06090030),
        (60_001, 0x06090031),
        (60_100, 0x06090031),
        (65_535, 0x06090031),
    ],
)
def test_other_periods_are_refused_and_change_nothing(bench, milliseconds, code):
    with refused(code):
        bench.sdo[0x1017].raw = milliseconds
    assert bench.sdo[0x1017].raw == 1000
    assert bench.run(2.0) == ["763#7F"] * 2


@pytest.mark.spec("C-025", "A-02")
def test_the_other_reading_cuts_what_is_beyond_a_step():
    bench = Bench("charger", heartbeat_step="floor")
    bench.sdo[0x1017].raw = 299
    assert bench.sdo[0x1017].raw == 200
    assert len(bench.run(1.0)) == 5
    with refused(0x06090032):
        bench.sdo[0x1017].raw = 99
    bench.sdo[0x1017].raw = 0
    assert bench.run(1.0) == []


@pytest.mark.spec("C-027")
def test_there_is_no_node_guarding(bench):
    assert bench.send("763#R") == []
    for index in (0x100C, 0x100D):
        assert aborted(ask(bench, index)) == (index, 0, 0x06020000)
