import pytest
import yaml

from canopen_twins.devices.gateway.model.errors import ENGINE_STATES, assignment
from canopen_twins.devices.gateway.model.parameters import Unit, catalogue, scaling
from canopen_twins.files.shipped import od_file

ROW = {
    "control_unit": "gateway",
    "number": "427",
    "name": "CanOpenMyNodeID",
    "range": "1..127",
    "resolution": "1",
    "level": "6",
    "unit": "",
    "default": "1",
    "source": "7.2.2",
}
SCALE = {"number": "2000", "full_scale": "4000", "unit": "rpm", "counts": "64000"}


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"control_unit": "motor"}, "line 2: 'motor' is not a valid Unit"),
        ({"number": "x"}, "line 2: invalid literal"),
        ({"range": "1"}, "line 2: invalid literal"),
        ({"default": "128"}, "line 2: gateway 427 CanOpenMyNodeID: 128 is not in 1..127"),
        ({"resolution": "0"}, "line 2: float division by zero"),
    ],
)
def test_a_wrong_row_of_the_parameters_is_named(change, complaint):
    with pytest.raises(ValueError, match=complaint):
        catalogue([ROW | change])


def test_a_missing_column_is_named():
    with pytest.raises(ValueError, match="line 2: there is no column 'level'"):
        catalogue([{key: value for key, value in ROW.items() if key != "level"}])


def test_a_number_is_there_once():
    with pytest.raises(ValueError, match="gateway 427 CanOpenMyNodeID: the number is there twice"):
        catalogue([ROW, ROW])


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"number": "1"}, "line 2: the governor has no parameter 1"),
        ({"number": "14401"}, "14401 CanOpenSendErrors: a single bit has no scale"),
        ({"full_scale": "0"}, "2000 Speed: full scale 0 is not above 0"),
        ({"counts": "65536"}, "2000 Speed: 65536 counts are not in 1..65535"),
        ({"number": "2908"}, "2908 ChargeAirTemp: 64000 counts are not in 1..32767"),
        ({"counts": "many"}, "line 2: invalid literal"),
    ],
)
def test_a_wrong_row_of_the_scaling_is_named(tables, change, complaint):
    with pytest.raises(ValueError, match=complaint):
        scaling(tables.catalogue, [SCALE | change])


def test_a_scale_is_there_once_and_complete(tables):
    with pytest.raises(ValueError, match="line 3: 2000 is there twice"):
        scaling(tables.catalogue, [SCALE, SCALE])
    with pytest.raises(ValueError, match="line 2: there is no column 'counts'"):
        scaling(tables.catalogue, [{"number": "2000", "full_scale": "1"}])


@pytest.mark.spec("G-067")
@pytest.mark.parametrize(
    ("number", "value", "internal"),
    [
        (2000, 1500, 0x5DC0),
        (2300, 20, 0x3200),
        (2905, 4.5, 0x7080),
        (2908, 57.6, 0x0733),
        (2908, -57.6, 0xF8CD),
        (2000, 9000, 0xFFFF),
        (2000, -1, 0x0000),
        (2908, -2000, 0x8000),
        (400, 1.5, 15),
        (16460, 100, 100),
    ],
)
def test_internal_values(tables, number, value, internal):
    assert tables.scaling.of(number).internal(value) == internal


@pytest.mark.spec("G-065")
@pytest.mark.parametrize(
    ("number", "analogue", "signed"),
    [(2000, True, False), (2908, True, True), (835, True, True), (14401, False, None)],
)
def test_what_is_analogue_and_signed(tables, number, analogue, signed):
    assert tables.scaling.analogue(number) is analogue
    assert not analogue or tables.scaling.of(number).signed is signed


def bits():
    with od_file("gateway_errors.yaml") as path:
        return yaml.safe_load(path.read_text("ascii"))


def test_error_bit_k_is_error_3000_plus_k():
    known = assignment(bits())
    for error in range(96):
        words = known.error_words(1 << error)
        assert words == tuple((1 << error % 16) * (error // 16 == word) for word in range(6))


def test_errors_and_states_without_a_bit_are_not_told():
    content = bits()
    content["error bits"][1][5] = None
    content["engine state bits"] = [None, "running"]
    known = assignment(content)
    assert known.error_words(0b11 << 5) == (1 << 6, 0, 0, 0, 0, 0)
    assert known.engine_word(dict.fromkeys(ENGINE_STATES, True)) == 0b10


def changed(where, value):
    def change(content):
        content["error bits"][1][where] = value

    return change


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (lambda content: content.pop("engine state bits"), "the keys are not just"),
        (lambda content: content["error bits"].pop(6), "not one list for each of 1..6"),
        (changed(0, 2999), "error bits 1: 2999 is none of 3000 to 3099"),
        (changed(0, 3001), "error bits: 3001 is there twice"),
        (lambda content: content["error bits"][2].append(3096), "error bits 2: is no list of at"),
        (lambda content: content["engine state bits"].append(None), "is no list of at most 8 bits"),
        (
            lambda content: content.update({"engine state bits": ["on"]}),
            "'on' is none of stopped to overspeed stop",
        ),
        (
            lambda content: content.update({"engine state bits": ["idle", "idle"]}),
            "engine state bits: 'idle' is there twice",
        ),
    ],
)
def test_a_wrong_assignment_is_named(change, complaint):
    content = bits()
    change(content)
    with pytest.raises(ValueError, match=complaint):
        assignment(content)


def test_an_assignment_is_a_mapping():
    with pytest.raises(ValueError, match="the keys are not just"):
        assignment(None)


@pytest.mark.spec("G-057")
def test_the_dictionary_has_the_printed_entries():
    with od_file("gateway.eds") as path:
        lines = path.read_text("ascii").splitlines()
    keys = [line for line in lines if line.startswith("AccessType=")]
    assert keys == ["AccessType=ro"] * 165


@pytest.mark.spec("G-003", "G-073", "G-074")
def test_the_dictionary_offers_neither_storing_nor_lss_nor_active_pdos():
    with od_file("gateway.eds") as path:
        text = path.read_text("ascii")
    assert "LSS_Supported=0" in text
    assert "[1010]" not in text
    assert text.count("DefaultValue=$NODEID+0x80000") == 20
    assert text.count("DefaultValue=0xFE") == 20


@pytest.mark.spec("G-004")
def test_there_are_16_tpdos_and_4_rpdos(tables):
    governor = tables.catalogue.of(Unit.GOVERNOR)
    assert [number for number in governor if 16460 <= number < 16480] == list(range(16460, 16473))
    assert [number for number in governor if number >= 16480] == list(range(16480, 16484))
