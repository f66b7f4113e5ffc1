import pytest

from canopen_twins.devices.gateway.model.configuration import Entry, Refusal
from canopen_twins.devices.gateway.model.state import GatewayState
from canopen_twins.devices.gateway.model.timing import cycles, microseconds

NO_BINARY = {"governor": {14401: 0, 14402: 0}}


def entries(pdo):
    return [(entry.index, entry.sub) for entry in pdo.entries]


@pytest.mark.spec("G-062", "G-063", "G-120")
@pytest.mark.parametrize(
    ("milliseconds", "count"),
    [(0, 0), (1, 1), (14, 1), (15, 1), (16, 1), (31, 1), (32, 2), (100, 6), (200, 12), (1000, 64)],
)
def test_times_become_whole_main_cycles_of_the_governor(milliseconds, count):
    assert cycles(milliseconds, 15625, 255) == count


@pytest.mark.spec("G-062", "G-063")
@pytest.mark.parametrize(("milliseconds", "count"), [(3984, 254), (3985, 255), (65535, 255)])
def test_no_more_than_255_of_them(milliseconds, count):
    assert cycles(milliseconds, 15625, 255) == count


@pytest.mark.spec("G-111", "G-117")
@pytest.mark.parametrize(
    ("milliseconds", "count"), [(0, 0), (1, 1), (15, 1), (100, 6), (1000, 62), (65535, 4095)]
)
def test_times_become_whole_main_cycles_of_the_gateway(milliseconds, count):
    assert cycles(milliseconds, 16000, 4095) == count


def test_time_has_a_grid():
    assert microseconds(0.015625) == 15625
    for seconds in (0.0001, -0.000125):
        with pytest.raises(ValueError, match="is not a multiple of 125 us"):
            microseconds(seconds)


@pytest.mark.spec("G-060", "G-065", "G-066", "G-071", "G-106")
def test_the_examples_of_the_manual_make_these_pdos(rig):
    dictionary = rig().on().system.dictionary
    assert {n: hex(pdo.identifier) for n, pdo in dictionary.tpdos.items()} == {
        1: "0x181",
        2: "0x281",
        4: "0x481",
        16: "0x57f",
    }
    assert {n: hex(pdo.identifier) for n, pdo in dictionary.rpdos.items()} == {
        1: "0x201",
        2: "0x301",
        3: "0x401",
        4: "0x501",
    }
    assert entries(dictionary.tpdos[4]) == [(0x2001, sub) for sub in (1, 2, 3, 4)]
    assert entries(dictionary.tpdos[16]) == [(0x2001, 49), (0x2002, 50), (0x2001, 51)]
    assert entries(dictionary.rpdos[1]) == [(0x2003, 1), (0x0006, 0), (0x2003, 2)]
    assert entries(dictionary.rpdos[2]) == [(0x2004, 1), (0x2004, 2)]
    assert entries(dictionary.rpdos[3]) == [(0x0006, 0), (0x0006, 0), (0x2004, 7)]
    assert entries(dictionary.rpdos[4]) == [(0x0006, 0)] * 3 + [(0x2004, 12)]


@pytest.mark.spec("G-072")
def test_a_mapping_entry_names_index_sub_index_and_16_bits():
    assert Entry(0x2002, 50).mapping == 0x20023210


@pytest.mark.spec("G-040", "G-041")
@pytest.mark.parametrize(("errors", "status"), [(0, 0), (1, 0), (0, 1), (1, 1)])
def test_binary_tpdos_are_active_by_two_parameters(plain, errors, status):
    rig = plain({"governor": {14401: errors, 14402: status}}).on()
    tpdos = rig.system.dictionary.tpdos
    wanted = {1: [1, 2, 3, 4], 2: [5, 6]} if errors else {}
    wanted |= {3: [7]} if status else {}
    binary = {n: [entry.sub for entry in pdo.entries] for n, pdo in tpdos.items() if n < 4}
    assert binary == wanted


@pytest.mark.spec("G-050", "G-051", "G-052", "G-053")
def test_sub_indices_are_those_of_the_active_words(rig):
    dictionary = rig({"governor": {14401: 0, 14402: 1}}).on().system.dictionary
    assert dictionary.subs(0x2000) == [1, 2, 3, 4, 5, 6, 7]
    assert dictionary.subs(0x2001) == [1, 2, 3, 4, 49, 51]
    assert dictionary.subs(0x2002) == [50]
    assert dictionary.subs(0x2003) == [1, 2]
    assert dictionary.subs(0x2004) == [1, 2, 7, 12]


@pytest.mark.spec("G-050", "G-051")
def test_the_errors_are_always_there_and_the_engine_state_is_not(plain):
    dictionary = plain(NO_BINARY).on().system.dictionary
    assert dictionary.subs(0x2000) == [1, 2, 3, 4, 5, 6]


@pytest.mark.spec("G-052", "G-065")
def test_all_52_words_can_be_used(plain):
    assignments = {16400 + place: 2908 if place % 2 else 2000 for place in range(52)}
    times = {16460 + place: 100 for place in range(13)}
    identifiers = {16404 + place: 0x701 - 20 + place for place in range(12)}
    rig = plain({"governor": assignments | times, "gateway": identifiers}).on()
    dictionary = rig.system.dictionary
    assert dictionary.subs(0x2001) == list(range(1, 53, 2))
    assert dictionary.subs(0x2002) == list(range(2, 53, 2))
    assert list(dictionary.tpdos) == [1, 2, *range(4, 17)]


@pytest.mark.spec("G-061", "G-066")
@pytest.mark.parametrize(
    ("change", "active"),
    [
        ({16460: 0}, False),
        ({16400: 0, 16401: 0, 16402: 0, 16403: 0}, False),
        ({16400: 9999, 16401: 4811, 16402: 14401, 16403: 12411}, True),
        ({16400: 9999, 16401: 14402, 16402: 14401, 16403: 12411}, False),
    ],
    ids=["no time", "nothing assigned", "a type of 0..3", "unknown and single bits"],
)
def test_an_analogue_tpdo_needs_a_time_and_something_to_send(plain, change, active):
    rig = plain({"governor": change}).on()
    assert (4 in rig.system.dictionary.tpdos) is active


@pytest.mark.spec("G-066")
def test_an_invalid_assignment_leaves_no_gap(plain):
    rig = plain({"governor": {16401: 1}}).on()
    assert entries(rig.system.dictionary.tpdos[4]) == [(0x2001, 1), (0x2001, 3), (0x2001, 4)]


@pytest.mark.spec("G-070")
@pytest.mark.parametrize("node", [2, 29, 126])
def test_predefined_identifiers_follow_the_node_number(rig, node):
    dictionary = rig({"gateway": {427: node}, "governor": {14402: 1}}).on().system.dictionary
    tpdos = {n: pdo.identifier - node for n, pdo in dictionary.tpdos.items() if n < 5}
    assert tpdos == {1: 0x180, 2: 0x280, 3: 0x380, 4: 0x480}
    rpdos = {n: pdo.identifier - node for n, pdo in dictionary.rpdos.items()}
    assert rpdos == {1: 0x200, 2: 0x300, 3: 0x400, 4: 0x500}


@pytest.mark.spec("G-071")
@pytest.mark.parametrize(("number", "tpdo"), [(16404, 5), (16407, 8), (16411, 12), (16415, 16)])
def test_the_other_identifiers_have_parameters(plain, number, tpdo):
    place = tpdo - 4
    governor = {16400 + 4 * place: 2000, 16460 + place: 100}
    rig = plain({"governor": governor, "gateway": {number: 0x7F0}}).on()
    assert rig.system.dictionary.tpdos[tpdo].identifier == 0x7F0


@pytest.mark.spec("G-105", "G-108")
@pytest.mark.parametrize(
    ("governor", "active"),
    [
        ({4827: 3}, {1: [(0x2003, 1)]}),
        ({4901: 3}, {1: [(0x0006, 0), (0x0006, 0), (0x2003, 2)], 2: [(0x0006, 0), (0x2004, 2)]}),
        ({}, {}),
        ({4827: 2, 4900: 1}, {}),
        ({4900: 3, 900: 0, 4827: 3, 827: 0}, {}),
    ],
    ids=["switch functions only", "a sensor only", "nothing", "other types", "nothing assigned"],
)
def test_rpdos_are_active_by_what_they_carry(plain, governor, active):
    rpdos = plain({"governor": governor}).on().system.dictionary.rpdos
    assert {number: entries(pdo) for number, pdo in rpdos.items()} == active


@pytest.mark.spec("G-106")
@pytest.mark.parametrize("channel", range(1, 13))
def test_a_channel_is_a_word_of_rpdo_2_to_4(plain, channel):
    rpdos = plain({"governor": {900: channel, 4900: 3}}).on().system.dictionary.rpdos
    carrier = 2 + (channel - 1) // 4
    assert list(rpdos) == [1, carrier]
    assert entries(rpdos[carrier])[-1] == (0x2004, channel)
    assert len(rpdos[carrier].entries) == (channel - 1) % 4 + 1


def refusal(rig):
    rig.system.power_on()
    rig.run(0.3)
    return rig.governor.programme.handshake.refusal


@pytest.mark.spec("G-076")
@pytest.mark.parametrize("identifier", [0x000, 0x080, 0x100, 0x581, 0x601, 0x701, 0x707])
def test_a_reserved_identifier_is_refused(plain, identifier):
    rig = plain({"gateway": {428: 7, 16415: identifier}})
    assert refusal(rig) is Refusal.RESERVED_IDENTIFIER


@pytest.mark.spec("G-076")
@pytest.mark.parametrize("identifier", [0x003, 0x57F, 0x081, 0x582, 0x602, 0x702, 0x7E5, 0x7FF])
def test_no_other_identifier_is_reserved(plain, identifier):
    assert refusal(plain({"gateway": {428: 7, 16415: identifier}})) is None


@pytest.mark.spec("G-076")
def test_without_a_partner_700h_is_reserved(plain):
    assert refusal(plain({"gateway": {16415: 0x700}})) is Refusal.RESERVED_IDENTIFIER


@pytest.mark.spec("G-075")
@pytest.mark.parametrize("identifier", [0x181, 0x481, 0x201, 0x501])
def test_an_identifier_is_used_once(rig, identifier):
    assert refusal(rig({"gateway": {16415: identifier}})) is Refusal.DUPLICATE_IDENTIFIER


@pytest.mark.spec("G-079")
def test_inactive_pdos_are_not_checked(plain):
    rig = plain({"gateway": {16404: 0x181, 16405: 0x000}})
    assert refusal(rig) is None
    assert rig.system.state is GatewayState.PRE_OPERATIONAL


@pytest.mark.spec("G-077")
def test_the_partner_is_another_node(plain):
    assert refusal(plain({"gateway": {428: 1}})) is Refusal.OWN_IS_PARTNER


@pytest.mark.spec("G-006")
@pytest.mark.parametrize("node", [0, 128])
def test_node_numbers_are_1_to_127(plain, node):
    with pytest.raises(ValueError, match=r"gateway 427 CanOpenMyNodeID: \d+ is not in 1..127"):
        plain({"gateway": {427: node}})
