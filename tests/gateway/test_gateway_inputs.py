import pytest

from canopen_twins.devices.gateway.model.state import MasterCommand

SENSOR_BITS = 1 << 5 | 1 << 6 | 1 << 11  # sensors 900, 901, 906 of the manual's example
CURRENT_LOAD_BIT = 1 << 6  # sensor 917, in the second word


def sensors(rig):
    """Which of the four CANopen sensors of the manual's examples are faulty."""
    return [rig.governor.desk.read(3005 + sensor) for sensor in (0, 1, 6, 17)]


def feed(rig, seconds=0.05, **rpdos):
    """Send RPDOs at once, then let time pass."""
    for name, words in rpdos.items():
        rig.system.receive_rpdo(int(name[-1]), words)
    return rig.run(seconds)


def feed_all(rig, switches=0, flags=0):
    feed(
        rig,
        rpdo1=(switches, 0, flags),
        rpdo2=(100, 200),
        rpdo3=(0, 0, 300),
        rpdo4=(0, 0, 0, 400),
    )


@pytest.fixture
def fed(rig):
    """Build a system in Operational that has got every RPDO once."""

    def build(*configurations):
        built = rig(*configurations).operational()
        feed_all(built)
        return built

    return build


@pytest.mark.spec("G-160", "G-162", "G-166")
def test_sensors_are_faulty_before_operational_and_before_their_first_rpdo(rig):
    rig = rig().on()
    rig.run(0.1)
    assert sensors(rig) == [1, 1, 1, 1]
    assert rig.system.value(0x2000, 1) & SENSOR_BITS == SENSOR_BITS
    assert rig.system.value(0x2000, 2) & CURRENT_LOAD_BIT
    rig.system.command(MasterCommand.OPERATIONAL)
    feed(rig, rpdo2=(1, 2), rpdo4=(0, 0, 0, 4))
    assert sensors(rig) == [0, 0, 1, 0]


@pytest.mark.spec("G-160", "G-099")
def test_sensors_become_faulty_when_operational_is_left(fed):
    rig = fed()
    assert sensors(rig) == [0, 0, 0, 0]
    rig.system.command(MasterCommand.PRE_OPERATIONAL)
    feed_all(rig)
    assert sensors(rig) == [1, 1, 1, 1]
    rig.system.command(MasterCommand.OPERATIONAL)
    rig.run(0.05)
    assert sensors(rig) == [1, 1, 1, 1]


@pytest.mark.spec("G-099")
def test_rpdos_outside_operational_change_no_object(rig):
    rig = rig().on()
    feed(rig, rpdo2=(7, 8))
    assert rig.system.value(0x2004, 1) == 0


def test_nothing_of_an_operational_period_counts_in_the_next(fed):
    rig = fed({"governor": {16483: 100}})
    feed_all(rig, flags=1)
    rig.system.command(MasterCommand.PRE_OPERATIONAL)
    rig.run(0.05)
    rig.system.command(MasterCommand.OPERATIONAL)
    feed(rig, rpdo2=(1, 2), seconds=0.07)
    assert (sensors(rig), rig.word) == ([0, 0, 1, 1], 0)


@pytest.mark.spec("G-053", "G-100")
def test_words_of_rpdos_are_in_the_dictionary(fed):
    rig = fed()
    feed_all(rig, switches=0x1234, flags=0x0042)
    assert [rig.system.value(0x2003, sub) for sub in (1, 2)] == [0x1234, 0x0042]
    assert [rig.system.value(0x2004, sub) for sub in (1, 2, 7, 12)] == [100, 200, 300, 400]


@pytest.mark.spec("G-109", "G-163")
@pytest.mark.parametrize(("channel", "place"), [(1, 0), (2, 1), (7, 2), (12, 3)])
def test_a_flag_makes_its_sensor_faulty_and_is_no_canopen_error(fed, channel, place):
    rig = fed()
    feed_all(rig, flags=1 << (channel - 1))
    assert sensors(rig) == [int(place == each) for each in range(4)]
    assert (rig.word, rig.governor.desk.read(3074)) == (0, 0)
    feed_all(rig)
    assert sensors(rig) == [0, 0, 0, 0]


@pytest.mark.spec("G-121", "G-122", "G-123", "G-161", "G-142")
def test_a_monitored_rpdo_that_stops_makes_its_sensors_faulty_until_it_is_back(fed):
    rig = fed({"governor": {16481: 100}})
    feed(rig, rpdo2=(1, 2), seconds=0.09)
    assert (sensors(rig), rig.word) == ([0, 0, 0, 0], 0)
    rig.run(0.06)
    assert (sensors(rig), rig.word) == ([1, 1, 0, 0], 0x0004)
    for unit in (rig.governor, rig.gateway):
        assert (unit.desk.read(12413), unit.desk.read(3074)) == (1, 1)
    feed(rig, rpdo2=(1, 2))
    assert (sensors(rig), rig.word) == ([0, 0, 0, 0], 0)


@pytest.mark.spec("G-164", "G-171")
def test_a_monitored_rpdo1_takes_all_sensors_and_switch_functions_along(fed):
    rig = fed({"governor": {16480: 100}})
    feed_all(rig, switches=1)
    assert rig.governor.programme.inputs.active(827)
    rig.run(0.1)
    assert sensors(rig) == [1, 1, 1, 1]
    assert not rig.governor.programme.inputs.active(827)


@pytest.mark.spec("G-120", "G-124")
def test_the_nominal_period_is_too_slow_for_its_own_monitoring(fed):
    rig = fed({"governor": {16481: 100}})
    tripped = 0
    for _ in range(40):
        feed(rig, rpdo2=(1, 2), seconds=0.1)
        tripped += rig.governor.desk.read(12413)
    assert tripped > 0


@pytest.mark.spec("G-120")
@pytest.mark.parametrize(("time", "passes"), [(0.093, 0), (0.095, 0), (0.13, 1)])
def test_monitoring_waits_for_whole_main_cycles(fed, time, passes):
    rig = fed({"governor": {16481: 100}})
    feed(rig, rpdo2=(1, 2), seconds=time)
    assert rig.governor.desk.read(12413) == passes


@pytest.mark.spec("G-120")
def test_an_inactive_rpdo_is_never_missed(plain):
    rig = plain({"governor": {16480: 100, 16481: 100}}).operational()
    rig.run(1.0)
    assert rig.word == 0


@pytest.mark.spec("G-142")
def test_the_time_error_stays_when_operational_is_left_and_goes_when_it_is_back(fed):
    rig = fed({"governor": {16481: 100}})
    rig.run(0.2)
    rig.system.command(MasterCommand.PRE_OPERATIONAL)
    rig.run(0.2)
    assert rig.word == 0x0004
    rig.system.command(MasterCommand.OPERATIONAL)
    rig.run(0.05)
    assert rig.word == 0


@pytest.mark.spec("G-142")
def test_clearing_takes_the_time_error_away_outside_operational_only(fed):
    rig = fed({"governor": {16481: 100}})
    rig.run(0.2)
    rig.governor.desk.clear_errors()
    rig.run(0.1)
    assert rig.word == 0x0004
    rig.system.command(MasterCommand.PRE_OPERATIONAL)
    rig.governor.desk.clear_errors()
    rig.run(0.1)
    assert rig.word == 0


@pytest.mark.spec("G-101", "G-102", "G-103")
def test_switch_functions_follow_their_bit_high_or_low_active(fed):
    rig = fed()
    active = rig.governor.programme.inputs.active
    assert (active(827), active(835)) == (False, True)
    feed_all(rig, switches=0b1_0001)
    assert (active(827), active(835)) == (True, False)


@pytest.mark.spec("G-101")
@pytest.mark.parametrize("bit", range(1, 17))
def test_every_bit_of_the_word_can_carry_a_function(plain, bit):
    rig = plain({"governor": {811: bit, 4811: 3, 812: -bit, 4812: 3}}).operational()
    inputs = rig.governor.programme.inputs
    for word in (1 << (bit - 1), 0xFFFF ^ 1 << (bit - 1)):
        feed(rig, rpdo1=(word,))
        assert inputs.active(811) is bool(word >> (bit - 1) & 1)
        assert inputs.active(812) is not inputs.active(811)


@pytest.mark.spec("G-101")
@pytest.mark.parametrize("governor", [{811: 0, 4811: 3}, {811: 1, 4811: 2}])
def test_what_is_not_assigned_or_not_by_canopen_is_off(fed, governor):
    rig = fed({"governor": governor})
    feed_all(rig, switches=0xFFFF)
    assert not rig.governor.programme.inputs.active(811)


@pytest.mark.spec("G-170", "G-172", "G-174")
def test_a_faulty_switch_function_is_off_even_if_low_active(rig):
    rig = rig().operational()
    active = rig.governor.programme.inputs.active
    assert not active(835)
    feed(rig, rpdo1=(0, 0, 0))
    assert active(835)
    rig.system.command(MasterCommand.STOP)
    rig.run(0.05)
    assert not active(835)


@pytest.mark.spec("G-104")
def test_engine_stop_is_not_taken_from_canopen(plain):
    with pytest.raises(ValueError, match=r"governor 4810 Type_EngineStop: 3 is not in 0..2"):
        plain({"governor": {4810: 3}})


@pytest.mark.spec("G-107", "G-100")
def test_a_sensor_by_canopen_is_what_the_governor_then_measures(fed):
    rig = fed()
    feed_all(rig)
    assert rig.governor.desk.read("CurrentLoad") == pytest.approx(400 / 640)
    rig.system.command(MasterCommand.PRE_OPERATIONAL)
    rig.run(0.05)
    assert rig.governor.desk.read("CurrentLoad") == 0


@pytest.mark.spec("G-106")
def test_a_short_rpdo_is_ignored_and_a_long_one_cut(fed):
    rig = fed()
    feed(rig, rpdo3=(1, 2))
    assert rig.system.value(0x2004, 7) == 300
    feed(rig, rpdo3=(1, 2, 3, 4))
    assert rig.system.value(0x2004, 7) == 3
    assert rig.governor.programme.inputs.rpdos[3].words == (1, 2, 3)


@pytest.mark.spec("G-107")
def test_external_setpoints_lead_the_engine(fed):
    rig = fed()
    feed(rig, rpdo1=(0, 0, 0), rpdo2=(32000, 48000))
    rig.run(8.0)
    assert rig.governor.desk.read("SpeedSetp") == pytest.approx(1250)
    feed(rig, rpdo1=(1, 0, 0))
    rig.run(5.0)
    assert rig.governor.desk.read("SpeedSetp") == pytest.approx(1525)


def test_idle_speed_comes_before_every_setpoint(plain):
    rig = plain({"governor": {811: 3, 4811: 3}}).operational()
    feed(rig, rpdo1=(4,), seconds=10.0)
    assert rig.governor.desk.read("SpeedSetp") == 700
    assert rig.governor.programme.control.states(0)["idle"]
