"""What a device file says beside its values: emergencies, faults, settings, a class, a profile."""

from dataclasses import fields

import pytest

from canopen_twins import Bench, UserError
from canopen_twins.cli import main
from canopen_twins.devices.eds.device_file import Profile as Keys
from canopen_twins.slave.profile import Profile

HOT = "emergencies: {Hot: {code: 0x4210, register: 0x09, detail: 0x0201, while: {Temperature: %s}}}"


def told(twin, **objects):
    """What it sends when objects have such values."""
    before = len(twin.sent)
    twin.set(**objects)
    return twin.sent[before:]


def test_an_emergency_is_active_while_its_condition_holds(bench):
    twin = bench(HOT % "{above: 600}")
    assert told(twin, Temperature=600) == []
    assert told(twin, Temperature=601) == ["085#1042090102000000"]
    assert twin.sdo["Error register"].raw == 0x09
    assert twin.sdo["Pre-defined error field"][1].raw == 0x02014210
    assert told(twin, Temperature=700) == []
    assert told(twin, Temperature=600) == ["085#0000000000000000"]


@pytest.mark.parametrize(
    ("condition", "holds"),
    [
        ("{below: -5}", {-6}),
        ("{equals: 7}", {7}),
        ("{above: 5, below: 7}", {6}),
        ("{above: warm}", {51}),
        ("{above: Voltage}", {51}),
    ],
)
def test_a_condition_compares_with_numbers_settings_and_objects(bench, condition, holds):
    twin = bench(f"{HOT % condition}\nsettings: {{warm: {{default: 50}}}}")
    twin.set(Voltage=50)
    for value in (-6, -5, 5, 6, 7, 50, 51):
        twin.set(Temperature=value)
        seen = bool(twin.sdo["Error register"].raw)
        assert seen == (value in holds or (value > 50 and 51 in holds)), value


def test_several_objects_have_all_to_be_so(bench):
    twin = bench(
        "emergencies: {Empty: {code: 0x3220, while: {Charge: {below: 5}, Current: {below: 0}}}}"
    )
    assert told(twin, Current=-1) == ["085#2032010000000000"]
    assert told(twin, Charge=5) == ["085#0000000000000000"]


def test_an_emergency_is_among_the_messages_by_its_name(bench):
    message = bench(HOT % "{above: 600}").device.messages["Hot"]
    assert (message.code, message.field) == (0x4210, bytes([1, 2, 0, 0, 0]))


FAULTS = """
values: {Voltage: {counts: 10}}
faults:
  frozen: {text: It hangs., hold: [Voltage]}
  open: {text: Nothing is measured., set: {Voltage: 65535, Temperature: 0x7FFF}}
  shifted: {text: It measures too much., offset: {Voltage: 3, Temperature: -40}}
"""


@pytest.mark.parametrize(
    ("fault", "during", "after"),
    [
        ("frozen", [20, 20], [30, 40]),
        ("open", [65535] * 2, [50, 60]),
        ("shifted", [33, 43], [50, 60]),
    ],
)
def test_a_fault_lasts_until_it_is_cleared(bench, fault, during, after):
    twin = bench(FAULTS)

    def course():
        for _ in range(2):
            twin.run(1)
            yield twin.values("Voltage")["Voltage"]

    assert [*course()] == [10, 20]
    twin.inject(fault)
    assert [*course()] == during
    twin.clear(fault)
    assert [*course()] == after


def test_a_fault_is_of_objects_that_do_not_move_too(bench):
    twin = bench(FAULTS)
    twin.set(Temperature=100)
    twin.inject("shifted")
    assert twin.sdo["Temperature"].raw == 60
    twin.inject("open")
    assert twin.sdo["Temperature"].raw == 0x7FFF
    twin.clear()
    assert twin.sdo["Temperature"].raw == 100


def test_a_fault_outlives_the_supply(bench):
    twin = bench(FAULTS)
    twin.inject("open")
    twin.power_off()
    twin.power_on()
    assert twin.sdo["Voltage"].raw == 65535
    twin.clear("open")
    assert twin.sdo["Voltage"].raw == 0


def test_what_follows_goes_by_what_is_read(bench):
    twin = bench(
        "values: {Voltage: {follows: Temperature}}\n"
        "faults: {shifted: {text: It measures too much., offset: {Temperature: 7}}}"
    )
    twin.inject("shifted")
    twin.run(0.01)
    assert twin.values("Voltage") == {"Voltage": 7}


SETTINGS = "settings: {load: {default: 5, low: 0, high: 10, unit: A, text: What flows}}"


def test_a_setting_has_its_range_and_its_words(write, capsys):
    path = str(write(f"{SETTINGS}\nvalues: {{Current: {{value: load}}}}"))
    assert Bench(path, load=7).values("Current") == {"Current": 7}
    with pytest.raises(UserError, match=r"^setting 'load' is 0.0 to 10.0, not 11.0$"):
        Bench(path, load=11)
    assert main(["settings", path]) == 0
    listed = " ".join(capsys.readouterr().out.split())
    assert "load 5.0 What flows [A], 0.0 to 10.0; may change while" in listed


def test_where_there_is_chance_there_is_a_seed(write, capsys):
    assert main(["settings", str(write("values: {Current: {value: 5, noise: 1}}"))]) == 0
    assert " seed 0 " in " ".join(capsys.readouterr().out.split())


def test_its_title_is_that_of_the_file_or_of_the_eds(bench):
    assert bench("title: The one in the cellar").device.title == "The one in the cellar"
    assert bench("").device.title == "nobody Battery (battery.eds)"


def test_a_profile_says_how_the_communication_differs(bench):
    write_beyond = "605#2B172000"  # no such object, as a download of two bytes
    assert bench("profile: {too_long: 0x06070010}").send("605#2317100001000000") == [
        "585#8017100010000706"
    ]
    assert bench("").send("605#2317100001000000") == ["585#8017100012000706"]
    assert bench("").send(f"{write_beyond}00000000") == ["585#8017200000000206"]
    assert bench("profile: {block: false}").send("605#A400100005000000") == ["585#8000100001000405"]


def test_the_keys_of_a_profile_are_those_of_the_slave():
    known = {field.name for field in fields(Profile)}
    assert set(Keys.model_fields) < known


CLASS = """
from canopen_twins import Emcy, Fault, Object
from canopen_twins.devices.eds import Device


class Pack(Device):
    def make_model(self):
        super().make_model()
        self.wet = False

    @property
    def objects(self):
        return {(0x2005, 0): Object(read=lambda: 42)}

    @property
    def emergencies(self):
        return [Emcy(0xFF00, 0x81)] * self.wet

    @property
    def faults(self):
        return {"water": Fault("It gets wet.", self.wets, lambda: None)}

    def wets(self):
        self.wet = True

    @property
    def report(self):
        return {"wet": self.wet}
"""


def test_a_class_does_what_a_file_cannot_say(bench, tmp_path):
    (tmp_path / "pack.py").write_text(CLASS)
    twin = bench(
        "class: pack:Pack\nvalues: {Voltage: {counts: 1}}\n"
        f"{HOT % '{above: 600}'}\n"
        "faults: {frozen: {text: It hangs., hold: [Voltage]}}"
    )
    twin.run(2)
    assert twin.values("Cell imbalance", "Voltage") == {"Cell imbalance": 42, "Voltage": 2}
    twin.inject("water")
    assert twin.sent[-1] == "085#00FF810000000000"
    assert told(twin, Temperature=601) == ["085#1042890102000000"]
    assert twin.report == {"wet": True, "Voltage": 2}
    assert set(twin.device.faults) == {"water", "frozen"}


PLAIN = """
from canopen_twins import Device, Object


class Plain(Device):
    eds = "none"
    title = "By class"

    @property
    def objects(self):
        return {(0x2005, 0): Object(read=lambda: 42)}
"""


def test_a_class_may_be_of_any_kind_of_device(bench, tmp_path):
    (tmp_path / "plain.py").write_text(PLAIN)
    twin = bench("class: plain:Plain\nvalues: {Voltage: {counts: 1}}")
    twin.run(2)
    assert twin.values("Cell imbalance", "Voltage") == {"Cell imbalance": 42, "Voltage": 2}
    twin.set(Temperature=5)
    assert twin.values("Temperature") == {"Temperature": 5}


@pytest.mark.parametrize("command", ["eds", "objects", "settings", "faults"])
def test_every_command_takes_its_path(write, command, capsys):
    assert main([command, str(write(f"{FAULTS}\n{SETTINGS}"))]) == 0
    shown = {"eds": "2001", "objects": "Voltage", "settings": "load", "faults": "frozen"}
    assert shown[command] in capsys.readouterr().out


STORY = """
version: 1
seed: 5
duration: 3
node: {device: battery.device.yaml, node_id: 5}
steps:
  - {at: 0.1, nmt: start}
  - {at: 1, set: {load: 100}}
  - {at: 1.5, set: {Temperature: 42}}
  - {at: 2, inject: frozen}
"""


def test_a_run_is_recorded_with_its_files_and_lived_through_again(write, tmp_path, capsys):
    write(
        "settings: {load: {default: 0}}\n"
        "values: {Current: {ramps: load, rate: 50}, Voltage: {wanders: 9, low: 0, high: 90}}\n"
        "faults: {frozen: {text: It hangs., hold: [Voltage]}}"
    )
    story = tmp_path / "story.yaml"
    story.write_text(STORY)
    assert main(["play", str(story), "--record", str(tmp_path / "record")]) == 0
    for path in tmp_path.glob("battery*"):
        path.unlink()
    assert main(["replay", str(tmp_path / "record")]) == 0
    assert "185#" in capsys.readouterr().out
