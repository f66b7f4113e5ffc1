import json

import pytest

from canopen_twins.devices.gateway.model.configuration import SENSORS, SWITCH_FUNCTIONS
from canopen_twins.devices.gateway.model.desk import SHOWN
from canopen_twins.devices.gateway.model.parameters import Unit
from canopen_twins.devices.gateway.model.state import GatewayState

# 11.2 to 11.5 as printed: number -> name, range, level
PRINTED = {
    400: ("CanStartTimeOutDelay", 0, 100, 6),
    401: ("CanMyNodeNumber", 1, 31, 6),
    402: ("CanDCNodeNumber", 1, 31, 6),
    410: ("HzmCanPrescaler", 0, 63, 6),
    411: ("HzmCanSyncJumpWidth", 0, 3, 6),
    412: ("HzmCanSamplingMode", 0, 1, 6),
    413: ("HzmCanPhaseSegment1", 0, 7, 6),
    416: ("HzmCanBaudrate", 125, 1000, 6),
    425: ("CanOpenPropSegment", 0, 7, 6),
    426: ("CanOpenBaudrate", 125, 1000, 6),
    427: ("CanOpenMyNodeID", 1, 127, 6),
    428: ("CanOpenPartnerNodeID", 0, 127, 6),
    429: ("CanOpHeartBeatTxTime", 0, 65535, 6),
    430: ("CanOpHeartBeatRxTime", 0, 65535, 6),
    1800: ("Level", 1, 7, 1),
    2401: ("CanTxBufferState", 0, 0xFFFF, 1),
    2404: ("CanTypeMismatch", 0, 1, 1),
    2410: ("CanDCNodeState31to16", 0, 0xFFFF, 6),
    3073: ("ErrCanComm2", 0, 1, 1),
    3099: ("EEPROMErrorCode", 0, 0xFFFF, 6),
    3170: ("SErrCanBus1", 0, 255, 1),
    3195: ("SExceptionNumber", 0, 65535, 1),
    3600: ("PowerSupply", 0, 55, 1),
    3840: ("HardwareVersion", 0, 9999, 1),
    3844: ("SerialDate", 0, 9912, 1),
    3865: ("CalculationTime", 0, 16.384, 1),
    3897: ("CStackTestFreeBytes", 0, 0x200, 6),
    4400: ("HzmCanCommDCOn", 0, 1, 6),
    4426: ("CanOpSegmOrBaudrate", 0, 1, 6),
    12405: ("CanOpOnline", 0, 1, 6),
    12411: ("CanOpDCResetErr", 0, 1, 6),
    12424: ("CanOpGWErrCanComm2", 0, 1, 6),
    16404: ("CanOpTPDO5-16ID(0)", 0, 0x7FF, 6),
    16415: ("CanOpTPDO5-16ID(11)", 0, 0x7FF, 6),
}

# 11.1: every number of the synoptical table
SYNOPTICAL = (
    *(400, 401, 402, *range(410, 417), *range(420, 431), 1800),
    *(*range(2401, 2407), 2410, 2411, 2424, 2425),
    *(*range(3070, 3075), 3076, 3077, 3078, 3085, 3090, 3093, 3094, 3099),
    *(*range(3170, 3175), 3176, 3177, 3178, 3185, 3190, *range(3193, 3199), 3600),
    *(*range(3840, 3846), 3850, 3851, 3865, 3870, *range(3895, 3899)),
    *(4400, 4416, 4426, *range(12400, 12406), *range(12410, 12416), *range(12419, 12425)),
    16404,
)

# chapter 7.1 and 9.5 to 9.7: every number named for the governor
GOVERNOR = (
    *(400, 401, 403, *range(410, 415), 416, 4416, 4406, 14401, 14402),
    *(810, 811, 827, 835, 4810, 4811, 4827, 4835),
    *(900, 901, 906, 917, 4900, 4901, 4906, 4917),
    *(2000, 2031, 2300, 2330, 2905, 2908, 2917, 3005, 3070, 3071, 3074),
    *(*range(16400, 16452), *range(16460, 16473), *range(16480, 16484)),
    *(*range(12401, 12405), *range(12411, 12416), *range(12419, 12425)),
)


@pytest.mark.parametrize("number", PRINTED)
def test_a_parameter_is_the_one_of_chapter_11(tables, number):
    parameter = tables.catalogue.find(Unit.GATEWAY, number)
    printed = (parameter.name, parameter.low, parameter.high, parameter.level)
    assert printed == PRINTED[number]


def test_no_number_of_the_manual_is_missing(tables):
    assert set(SYNOPTICAL) <= set(tables.catalogue.of(Unit.GATEWAY))
    assert set(GOVERNOR) <= set(tables.catalogue.of(Unit.GOVERNOR))
    assert {*SWITCH_FUNCTIONS, *SENSORS} <= set(tables.catalogue.of(Unit.GOVERNOR))


@pytest.mark.parametrize("unit", Unit)
def test_names_and_sources_are_complete(tables, unit):
    parameters = tables.catalogue.of(unit).values()
    names = [parameter.name for parameter in parameters]
    assert len(names) == len(set(names))
    assert all(parameter.source for parameter in parameters)


def test_a_measurement_is_told_by_its_number(tables):
    writable = {427: True, 12401: False, 4400: True, 16404: True}  # one of each list of chapter 11
    for number, expected in writable.items():
        assert tables.catalogue.find(Unit.GATEWAY, number).writable is expected


def test_the_same_number_means_different_things_in_the_two_units(tables):
    find = tables.catalogue.find
    assert find(Unit.GATEWAY, 16404).name == "CanOpTPDO5-16ID(0)"
    assert find(Unit.GOVERNOR, 16404).name == "CanOpTPDO5Assign(0)"


@pytest.mark.parametrize(("alias", "number"), [(409, 416), (4409, 4416)])
def test_the_governor_knows_two_numbers_by_another_one(tables, alias, number):
    assert tables.catalogue.find(Unit.GOVERNOR, alias).number == number
    with pytest.raises(ValueError, match=f"the gateway has no parameter {alias}"):
        tables.catalogue.find(Unit.GATEWAY, alias)


@pytest.mark.parametrize("unit", Unit)
def test_every_parameter_of_a_running_unit_can_be_read_and_is_in_its_range(rig, tables, unit):
    machine = getattr(rig().on(), unit.value)
    for number, parameter in tables.catalogue.of(unit).items():
        assert parameter.low <= machine.desk.read(number) <= parameter.high, parameter.title


@pytest.mark.spec("G-220")
def test_a_unit_identifies_itself(plain):
    desk = plain().on().gateway.desk
    numbers = (3840, 3841, 3842, 3843, 3844, 3845, 3850, 3851)
    assert [desk.read(number) for number in numbers] == [100, 0, 10100, 100, 405, 1, 0, 0]
    desk.show("SerialDate", 9912)
    assert desk.read(3844) == 9912
    with pytest.raises(ValueError, match=r"gateway 3844 SerialDate: 9913 is not in 0\.\.9912"):
        desk.show(3844, 9913)


@pytest.mark.spec("G-220")
def test_saving_keeps_which_pc_it_was(plain):
    desk = plain().on().gateway.desk
    desk.connect(identifier=4711)
    assert desk.read("LastIdentifier") == 0
    desk.save()
    assert desk.read("LastIdentifier") == 4711


@pytest.mark.spec("G-005")
@pytest.mark.parametrize("unit", ["gateway", "governor"])
def test_a_change_acts_after_saving_and_a_reset_of_that_unit(plain, unit):
    rig = plain().on()
    number, value = {"gateway": (427, 9), "governor": (16460, 0)}[unit]

    def acts():
        dictionary = rig.system.dictionary
        return {
            "gateway": dictionary.tpdos[1].identifier == 0x189,
            "governor": 4 not in dictionary.tpdos,
        }[unit]

    machine = getattr(rig, unit)
    machine.desk.write(number, value)
    assert machine.desk.read(number) == value
    machine.desk.save()
    rig.run(0.5)
    assert not acts()
    machine.reset()
    rig.run(0.5)
    assert acts()


@pytest.mark.spec("G-005")
def test_a_reset_without_saving_drops_the_change(plain):
    rig = plain().on()
    rig.gateway.desk.write(427, 9)
    rig.gateway.reset()
    rig.run(0.5)
    assert rig.gateway.desk.read(427) == 1


@pytest.mark.parametrize(
    ("key", "value", "complaint"),
    [
        (427, 128, "gateway 427 CanOpenMyNodeID: 128 is not in 1..127"),
        (427, 1.5, "gateway 427 CanOpenMyNodeID: 1.5 is no multiple of 1"),
        (427, "1", "gateway 427 CanOpenMyNodeID: '1' is not a number"),
        (427, True, "gateway 427 CanOpenMyNodeID: True is not a number"),
        (427, float("nan"), "gateway 427 CanOpenMyNodeID: nan is not a number"),
        (426, 800, "gateway 426 CanOpenBaudrate: 800 is none of 125, 250, 500, 1000"),
        (400, 0.05, "gateway 400 CanStartTimeOutDelay: 0.05 is no multiple of 0.1"),
        (2405, 1, "gateway 2405 CanOnline: is only shown"),
        (403, 1, "the gateway has no parameter 403"),
        ("CanOpenMyNodeId", 1, "no parameter 'CanOpenMyNodeId', did you mean 'CanOpenMyNodeID'?"),
        (4.5, 1, "the gateway has no parameter 4.5"),
    ],
)
def test_a_wrong_value_is_refused_in_one_line(plain, key, value, complaint):
    desk = plain().on().gateway.desk
    with pytest.raises(ValueError, match=r"^[^\n]+$") as refused:
        desk.write(key, value)
    assert complaint in str(refused.value)


def test_what_comes_about_by_itself_cannot_be_set_to_be_shown(plain):
    with pytest.raises(ValueError, match="gateway 3071 ErrCanComm1: comes about by itself"):
        plain().gateway.desk.show(3071, 1)


def test_what_can_be_shown_is_made_by_nothing_else(plain):
    rig = plain().on()
    assert not set(SHOWN) & set(rig.gateway.programme.live)
    assert not set(SHOWN) & set(rig.governor.programme.live)


def test_a_configuration_may_use_numbers_and_names(plain):
    rig = plain({"gateway": {"CanOpenMyNodeID": 7}, "governor": {409: 250}}).on()
    assert rig.gateway.desk.read(427) == 7


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        ({"gatway": {}}, "'gatway' is not 'gateway' or 'governor'"),
        ({"gateway": None}, "'gateway' is not 'gateway' or 'governor' with parameters"),
        ({"gateway": {427: 7, "CanOpenMyNodeID": 7}}, "427 CanOpenMyNodeID: is given twice"),
        ({"gateway": {427: 7}, "governor": {416: 300}}, "416 CanBaudrate: 300 is none of"),
    ],
)
def test_a_wrong_configuration_changes_nothing(plain, content, complaint):
    rig = plain()
    with pytest.raises(ValueError, match=r"^[^\n]+$") as refused:
        rig.system.configure(content)
    assert complaint in str(refused.value)
    assert rig.on().gateway.desk.read(427) == 1


@pytest.mark.spec("G-181")
def test_what_is_kept_survives_in_a_file(plain, rig):
    before = plain({"gateway": {427: 9}}).on()
    before.gateway.break_off(1, address=2)
    before.gateway.desk.connect(identifier=3)
    before.run(0.1)
    before.gateway.desk.save()
    after = rig()
    after.system.restore(json.loads(json.dumps(before.system.kept)))
    after.on()
    assert [after.gateway.desk.read(n) for n in (427, 3194, 3195, 3196, 3851)] == [9, 1, 1, 2, 3]
    assert after.system.state is GatewayState.PRE_OPERATIONAL
    assert after.system.kept == before.system.kept


@pytest.mark.parametrize(
    "content",
    [
        {"gateway": 1},
        {"gateway": {"parameters": {"427": 200}}},
        {"gateway": {"parameters": {"x": 2}}},
        {"gateway": {"errors": []}},
        {"gateway": {"exception": [1]}},
        {"gateway": {"last identifier": "x"}},
    ],
)
def test_a_damaged_file_is_refused(rig, content):
    with pytest.raises(ValueError, match=r"^[^\n]+$"):
        rig().system.restore(content)
