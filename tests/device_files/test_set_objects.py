"""Objects that are set by hand: on a bench, in a scenario, for a device of a file."""

import pytest

from canopen_twins import Bench, UserError, load, play

from .conftest import EXAMPLES

FAN = str(EXAMPLES / "canopen-fan" / "canopen_fan" / "fan.eds")
BATTERY = str(EXAMPLES / "battery" / "battery.eds")


@pytest.fixture
def battery():
    return Bench(BATTERY, node_id=5)


@pytest.mark.parametrize("name", ["Voltage", "0x2001", "0x2001:00"])
def test_what_is_only_measured_is_set_by_its_name_or_its_address(battery, name):
    battery.set(**{name: 48000})
    assert battery.send("605#4001200000000000") == ["585#4B01200080BB0000"]


def test_a_change_is_sent_as_any_other(battery):
    battery.send("000#0105")
    battery.run(0.2)  # its inhibit time is 0.1 s
    before = len(battery.sent)
    battery.set(Voltage=0x1234, Current=-2)
    assert battery.sent[before:] == ["185#3412FEFFFFFF"]


@pytest.mark.parametrize(
    "timing", [{"timing": "typical"}, {"timing": "worst"}, {"measure_time": 1}]
)
def test_what_is_measured_late_or_with_noise_is_set_as_well(timing):
    battery = Bench(BATTERY, node_id=5, **timing)
    for voltage in range(40000, 50000, 1000):
        battery.run(2)
        battery.set(Voltage=voltage, Current=-voltage)
        battery.run(2)
        told = battery.values("Voltage", "Current")
        assert told == pytest.approx({"Voltage": voltage, "Current": -voltage}, abs=5)


def test_it_outlives_resets_and_the_supply_as_settings_do(battery):
    battery.set(Voltage=48000)
    for reset in ("000#8105", "000#8205"):
        battery.send(reset)
        assert battery.values("Voltage") == {"Voltage": 48000}
    battery.power_off()
    battery.set(Temperature=7)
    battery.power_on()
    assert battery.values("Voltage", "Temperature") == {"Voltage": 48000, "Temperature": 7}


def test_what_a_master_may_write_is_written_as_it_does(battery):
    battery.set(**{"Undervoltage limit": 45000})
    assert battery.sdo["Undervoltage limit"].raw == 45000
    with pytest.raises(UserError, match="does not take that: 39999 is below 40000"):
        battery.set(**{"Undervoltage limit": 39999})


def test_what_the_node_says_is_not_set(battery):
    with pytest.raises(UserError, match=r"'Error register' \(0x1001:00\) is what the node says"):
        battery.set(**{"Error register": 1})


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"Voltag": 1}, "unknown setting or object 'Voltag': did you mean 'Voltage'?"),
        ({"node_id": 7}, "setting 'node_id' is taken over at power-on only"),
        ({"Voltage": 65536}, "object 'Voltage' has room for 0..65535, not for 65536"),
        ({"Voltage": "much"}, "object 'Voltage' wants a whole number, not 'much'"),
        ({"Voltage": 1.5}, "object 'Voltage' wants a whole number, not 1.5"),
        ({"State of charge": 1e39}, "object 'State of charge' has room for -3.4028234e+38.."),
        ({"0x2099": 1}, "unknown object '0x2099'"),
        ({"0x1018": 1}, "0x1018 is a record: say which entry of it, such as 0x1018:01"),
    ],
)
def test_what_cannot_be_set_is_told_and_nothing_else_is(battery, given, words):
    with pytest.raises(UserError) as refusal:
        battery.set(Current=7, **given)
    assert str(refusal.value).startswith(words)
    assert battery.values("Current") == {"Current": 0}


AMBIGUOUS = """
[2100]
ParameterName=modules
DataType=0x0005
AccessType=ro
[2101]
ParameterName=Pressure
DataType=0x0005
AccessType=ro
[2102]
ParameterName=Pressure
DataType=0x0005
AccessType=ro
"""


@pytest.fixture
def ambiguous(tmp_path):
    path = tmp_path / "ambiguous.eds"
    path.write_text(AMBIGUOUS)
    return Bench(str(path))


def test_a_setting_comes_before_an_object_of_its_name(ambiguous):
    with pytest.raises(UserError, match="setting 'modules' is taken over at power-on only"):
        ambiguous.set(modules=1)
    ambiguous.set(**{"0x2100": 1})
    assert ambiguous.values("modules") == {"modules": 1}


def test_a_name_that_several_objects_have_is_told(ambiguous):
    with pytest.raises(UserError, match="'Pressure' is the name of 0x2101:00 and 0x2102:00"):
        ambiguous.set(Pressure=1)


STORY = f"""
version: 1
node: {{device: {FAN}, node_id: 5}}
steps:
  - at: 0.1
    set: {{Actual speed: 80}}
  - at: 0.1
    expect: {{value: {{Actual speed: 80}}}}
"""


def test_a_step_sets_an_object(tmp_path):
    path = tmp_path / "story.yaml"
    path.write_text(STORY)
    assert play(load(path)).ok


@pytest.mark.parametrize(
    ("step", "line"),
    [
        (
            "set: {Actual sped: 80}",
            "6:11: unknown setting or object 'Actual sped': did you mean 'Actual speed'?",
        ),
        (
            "set: {Actual speed: 70000}",
            "6:25: object 'Actual speed' has room for 0..65535, not for 70000",
        ),
        ("set: {0x2099: 1}", "6:11: unknown object '0x2099': did you mean '0x2001'?"),
    ],
)
def test_a_step_that_cannot_is_told_with_its_place(tmp_path, step, line):
    path = tmp_path / "story.yaml"
    path.write_text(STORY.replace("set: {Actual speed: 80}", step))
    with pytest.raises(UserError) as mistake:
        load(path)
    assert str(mistake.value).splitlines()[0] == f"{path}:{line}"


def test_a_device_of_python_has_settings_only(tmp_path):
    with pytest.raises(UserError, match="unknown setting 'Actual voltage'"):
        Bench("topcon", node_id=5).set(**{"Actual voltage": 1})
