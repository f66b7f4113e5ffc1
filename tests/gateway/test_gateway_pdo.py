from itertools import pairwise

import pytest

from canopen_twins.devices.gateway.model.canopen_side import FirstTpdo, TpdoFrame
from canopen_twins.devices.gateway.model.state import MasterCommand

SILENT_ENGINE = {"governor": {16460: 0, 16472: 0}}  # no analogue TPDOs


def tpdos(sent, *numbers):
    return [
        (at, message.number, message.words)
        for at, message in sent
        if isinstance(message, TpdoFrame) and message.number in numbers
    ]


@pytest.fixture
def binary(plain):
    """Build a system that sends all binary TPDOs and no other, with the engine standing."""

    def build(**options):
        rig = plain(SILENT_ENGINE, {"governor": {14402: 1}, "gateway": {429: 0}}, **options)
        rig.governor.operation.run = False
        return rig

    return build


def start(rig):
    rig.system.command(MasterCommand.OPERATIONAL)


@pytest.mark.spec("G-042", "G-043")
def test_binary_tpdos_are_sent_once_and_then_on_change_only(binary):
    rig = binary().on()
    start(rig)
    assert [number for _, number, _ in tpdos(rig.run(0.02), 1, 2, 3)] == [1, 2, 3]
    assert rig.run(20.0) == []


@pytest.mark.spec("G-042", "G-044", "G-045")
def test_only_the_tpdo_with_the_change_is_sent(binary):
    rig = binary().on()
    start(rig)
    rig.run(0.1)
    rig.governor.fail(3005)
    assert [(n, words) for _, n, words in tpdos(rig.run(0.1), 1, 2, 3)] == [(1, (0x20, 0, 0, 0))]
    rig.gateway.feed(7.0)
    assert [(n, words) for _, n, words in tpdos(rig.run(0.1), 1, 2, 3)] == [(2, (0, 0x20))]
    rig.governor.operation.run = True
    assert [(n, words) for _, n, words in tpdos(rig.run(0.02), 1, 2, 3)] == [(3, (0x03,))]


@pytest.mark.spec("G-042")
def test_two_changes_within_one_governor_cycle_are_one_tpdo(binary):
    rig = binary().on()
    start(rig)
    rig.run(0.1)
    rig.governor.fail(3005)
    rig.governor.fail(3006)
    assert [words for _, _, words in tpdos(rig.run(0.1), 1)] == [(0x60, 0, 0, 0)]


@pytest.mark.spec("G-042", "G-014")
def test_binary_tpdos_need_operational(binary):
    rig = binary().on()
    rig.governor.fail(3005)
    assert rig.run(0.1) == []
    assert rig.system.value(0x2000, 1) == 0x20


@pytest.mark.parametrize(
    ("first", "expected"),
    [(FirstTpdo.ALWAYS, [1, 2, 3]), (FirstTpdo.NONZERO, [3]), (FirstTpdo.NEVER, [])],
)
def test_the_first_binary_tpdo_is_a_matter_of_reading(binary, first, expected):
    rig = binary(first_tpdo=first).on()
    start(rig)
    assert [number for _, number, _ in tpdos(rig.run(0.1), 1, 2, 3)] == expected


@pytest.mark.spec("G-045", "G-050", "G-054")
def test_errors_of_both_units_are_in_the_dictionary_without_the_tpdos(plain):
    rig = plain({"governor": {14401: 0}}).on()
    rig.governor.fail(3028)
    rig.gateway.feed(7.0)
    rig.run(0.05)
    assert [rig.system.value(0x2000, sub) for sub in range(1, 7)] == [0, 1 << 12, 0, 0, 0, 1 << 5]


@pytest.mark.spec("G-055")
def test_the_engine_state_is_eight_bits(plain):
    rig = plain({"governor": {14402: 1}})
    seen = []
    rig.on()
    for _ in range(100):
        rig.run(0.1)
        seen.append(rig.system.value(0x2000, 7))
    assert max(seen) < 0x100
    assert {word & 0x1E for word in seen} == {0x02, 0x04, 0x14}  # cranking, ramp, setpoint


@pytest.mark.spec("G-008", "G-060", "G-062", "G-064")
def test_analogue_tpdos_keep_their_quantised_period(plain):
    rig = plain({"governor": {16460: 200}}).operational()
    times = [at for at, *_ in tpdos(rig.run(3.0), 4)]
    assert {round(b - a, 3) for a, b in pairwise(times)} == {187.5}


@pytest.mark.spec("G-064", "G-031", "G-032", "G-030")
@pytest.mark.parametrize("command", [MasterCommand.PRE_OPERATIONAL, MasterCommand.STOP])
def test_pdos_stop_when_operational_is_left_and_go_on_when_it_is_back(plain, command):
    rig = plain({"gateway": {429: 0}}).operational()
    rig.system.command(command)
    assert rig.run(0.5) == []
    start(rig)
    assert {number for _, number, _ in tpdos(rig.run(0.1), *range(1, 17))} == {1, 2, 4, 16}


@pytest.mark.spec("G-060")
def test_tpdos_of_one_cycle_come_in_ascending_order(rig):
    rig = rig({"governor": {16472: 16}}).on()
    start(rig)
    first = tpdos(rig.run(0.02), *range(1, 17))
    assert [number for _, number, _ in first] == [1, 2, 4, 16]
    assert len({at for at, *_ in first}) == 1


@pytest.mark.spec("G-060", "G-067")
def test_words_are_internal_values_in_the_order_of_assignment(plain):
    rig = plain().operational()
    rig.run(20.0)
    *_, (_, _, words) = tpdos(rig.run(0.1), 4)
    assert words[:2] == (0x5DC0, 0x5DC0)
    *_, (_, _, words) = tpdos(rig.run(0.1), 16)
    assert words[:2] == (0x7080, 25 * 32)
    assert rig.system.value(0x2001, 49) == 0x7080


@pytest.mark.spec("G-066")
def test_a_shortened_tpdo_has_fewer_words(plain):
    rig = plain({"governor": {16401: 1}}).operational()
    assert {len(words) for _, _, words in tpdos(rig.run(0.1), 4)} == {3}


@pytest.mark.spec("G-065")
def test_parameters_of_8_bits_are_widened(plain):
    governor = {16400: 835, 16401: 827, 16402: 16472, 16403: 401}
    rig = plain({"governor": governor}).operational()
    *_, (_, _, words) = tpdos(rig.run(0.1), 4)
    assert words == (0xFFFB, 1, 100, 1)
    entries = [(entry.index, entry.sub) for entry in rig.system.dictionary.tpdos[4].entries]
    assert entries == [(0x2002, 1), (0x2002, 2), (0x2001, 3), (0x2001, 4)]


@pytest.mark.spec("G-062")
def test_the_first_cyclic_tpdo_comes_within_one_period(plain):
    rig = plain({"governor": {16460: 1000}}).on()
    rig.run(0.77)
    start(rig)
    assert len(tpdos(rig.run(1.0), 4)) == 1


def test_the_cyclic_tpdos_begin_with_the_command_pre_operational(plain):
    rig = plain({"governor": {16460: 1000}, "gateway": {429: 0}}).operational()
    rig.run(0.4)
    rig.system.command(MasterCommand.RESET_NODE)
    ((boot_up, _),) = rig.run(0.05)
    start(rig)
    (first, *_), *_ = tpdos(rig.run(1.1), 4)
    assert 985 < first - boot_up < 1002


def test_another_main_cycle_is_another_grid(plain):
    rig = plain({"governor": {16460: 25}}, governor_cycle=0.01).operational()
    times = [at for at, *_ in tpdos(rig.run(1.0), 4)]
    assert {round(b - a, 3) for a, b in pairwise(times)} == {20.0}


@pytest.mark.spec("G-050")
def test_the_errors_are_in_the_dictionary_from_its_first_moment(plain):
    rig = plain()
    rig.governor.fail(3005)
    rig.system.power_on()
    rig.run(0.220625)
    assert rig.system.listening
    assert rig.system.value(0x2000, 1) == 0x20
