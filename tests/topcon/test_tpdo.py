import pytest

from .bus import ENTER_PREOP, RESET_COMMUNICATION, START, STOP, SYNC, refused, run

REQUEST = "185#R"
ZEROS = ["185#0000000000000000"]
AT_200_V = ["185#D007000000000300"]
TPDOS = {1: 0x185, 2: 0x80000285, 3: 0x80000385, 4: 0x80000485}


def record(bench, number=1):
    return bench.sdo[f"Transmit PDO {number} Communication Parameter"]


def cob_id(bench, number=1):
    return record(bench, number)[f"COB-ID TPDO{number}"]


@pytest.fixture
def operational(topcon):
    topcon.send(START)
    return topcon


@pytest.fixture
def of_type(operational):
    def of_type(value):
        record(operational)["Transmission type"].raw = value
        return operational

    return of_type


def to_200_volt(bench):
    run(bench, voltage=2000)
    bench.run(1.0)


@pytest.mark.spec("T-140")
@pytest.mark.parametrize("number", TPDOS)
def test_tpdo1_is_valid_the_others_are_not_and_all_are_sent_on_request(topcon, number):
    assert record(topcon, number)[0].raw == 2
    assert cob_id(topcon, number).raw == TPDOS[number]
    assert record(topcon, number)["Transmission type"].raw == 253


@pytest.mark.spec("T-070")
def test_with_the_defaults_no_pdo_is_sent_unless_asked_for(operational):
    to_200_volt(operational)
    operational.set(load="resistor 10")
    operational.send(SYNC)
    operational.run(10)
    assert [frame for frame in operational.sent if frame.startswith("185")] == []


@pytest.mark.spec("T-150", "T-040")
def test_tpdo1_has_voltage_current_power_and_state_in_this_order(operational):
    operational.set(load="resistor 10")
    run(operational, voltage=2000)
    operational.run(1.0)
    objects = [operational.sdo[index].raw for index in range(0x2020, 0x2024)]
    assert objects == [2000, 800, 500, 0x0003]
    assert operational.send(REQUEST) == ["185#D0072003F4010300"]


@pytest.mark.spec("T-150", "T-130")
def test_the_mapping_of_tpdo1_is_fixed(topcon):
    mapping = topcon.sdo["Transmit PDO 1 Mapping Parameter"]
    read = [mapping[subindex].raw for subindex in range(5)]
    assert read == [4, 0x20200010, 0x20210010, 0x20220010, 0x20230010]
    for subindex in range(5):
        with refused(0x06010002):
            mapping[subindex].raw = 0


@pytest.mark.spec("T-141", "T-145", "A-31")
def test_the_transmission_types_are_1_to_240_252_and_253(topcon):
    entry = record(topcon)["Transmission type"]
    for value in range(256):
        before = entry.raw
        if value in {*range(1, 241), 252, 253}:
            entry.raw = value
            assert entry.raw == value
        else:
            with refused(0x06090030):
                entry.raw = value
            assert entry.raw == before


@pytest.mark.spec("T-142", "A-32")
@pytest.mark.parametrize("every", [1, 2, 3, 7, 239, 240])
def test_a_cyclic_tpdo_is_sent_at_every_so_manieth_sync(of_type, every):
    topcon = of_type(every)
    sent = [len(topcon.send(SYNC)) for _ in range(3 * every)]
    assert sent == 3 * ([0] * (every - 1) + [1])


@pytest.mark.spec("T-142")
def test_a_cyclic_tpdo_has_the_values_of_its_sync(of_type):
    topcon = of_type(1)
    assert topcon.send(SYNC) == ZEROS
    to_200_volt(topcon)
    assert topcon.send(SYNC) == AT_200_V


@pytest.mark.spec("A-32")
def test_the_count_begins_with_the_write_of_the_type(of_type):
    topcon = of_type(3)
    topcon.send(SYNC)
    topcon.send(SYNC)
    of_type(3)
    assert [len(topcon.send(SYNC)) for _ in range(3)] == [0, 0, 1]


@pytest.mark.spec("A-32")
def test_the_count_begins_with_operational(of_type):
    topcon = of_type(3)
    topcon.send(SYNC)
    topcon.send(SYNC)
    topcon.send(ENTER_PREOP)
    topcon.send(START)
    assert [len(topcon.send(SYNC)) for _ in range(3)] == [0, 0, 1]


@pytest.mark.spec("T-143")
def test_type_252_is_composed_at_sync_and_sent_on_request(of_type):
    topcon = of_type(252)
    assert topcon.send(SYNC) == []
    to_200_volt(topcon)
    assert topcon.send(REQUEST) == ZEROS
    assert topcon.send(SYNC) == []
    assert topcon.send(REQUEST) == AT_200_V


@pytest.mark.spec("A-33")
def test_type_252_before_any_sync_has_the_values_of_the_moment(of_type):
    topcon = of_type(252)
    to_200_volt(topcon)
    assert topcon.send(REQUEST) == AT_200_V


@pytest.mark.spec("T-144", "T-121")
def test_type_253_is_composed_at_the_request(operational):
    assert operational.send(REQUEST) == ZEROS
    to_200_volt(operational)
    assert operational.send(SYNC) == []
    assert operational.send(REQUEST) == AT_200_V


@pytest.mark.spec("A-34")
def test_a_cyclic_tpdo_is_also_sent_on_request_as_it_was_sent_last(of_type):
    topcon = of_type(2)
    topcon.send(SYNC)
    topcon.send(SYNC)
    to_200_volt(topcon)
    assert topcon.send(REQUEST) == ZEROS
    topcon.send(SYNC)
    assert topcon.send(SYNC) == AT_200_V
    assert topcon.send(REQUEST) == AT_200_V


@pytest.mark.spec("T-015")
@pytest.mark.parametrize("command", [ENTER_PREOP, STOP, RESET_COMMUNICATION])
def test_outside_operational_no_tpdo_is_sent(of_type, command):
    topcon = of_type(1)
    topcon.send(command)
    assert [topcon.send(frame) for frame in (SYNC, REQUEST, SYNC)] == [[], [], []]


@pytest.mark.spec("T-147", "A-35")
@pytest.mark.parametrize("number", [2, 3, 4])
def test_a_tpdo_without_content_is_never_sent_even_when_it_is_valid(operational, number):
    assert operational.sdo[f"Transmit PDO {number} Mapping Parameter"][0].raw == 0
    can_id = TPDOS[number] & 0x7FF
    cob_id(operational, number).raw = can_id
    assert cob_id(operational, number).raw == can_id
    assert operational.send(f"{can_id:03X}#R") == []
    record(operational, number)["Transmission type"].raw = 1
    assert operational.send(SYNC) == []


@pytest.mark.spec("T-144")
def test_a_data_frame_is_no_request(operational):
    assert operational.send("185#") == []
    assert operational.send("185#0000000000000000") == []
