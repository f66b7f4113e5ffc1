"""What is wrong with a device file is told with its place, all at once."""

import json
import os
import re

import jsonschema
import pytest
import yaml

from canopen_twins import Bench, UserError, devices
from canopen_twins.cli import main
from canopen_twins.devices.eds import device_file

from .conftest import EXAMPLES


def told(path):
    with pytest.raises(UserError) as mistake:
        devices.find(str(path))
    return [line.replace(f"{path.parent}/", "") for line in str(mistake.value).splitlines()]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "values: {Voltag: {value: 1}}",
            "3:10: unknown object 'Voltag': did you mean 'Voltage'?",
        ),
        ("values: {Voltage: {valu: 1}}", "3:20: unknown key 'valu': did you mean 'value'?"),
        (
            "values: {Voltage: {unit: V}}",
            "3:19: nothing that it does: a value has one of value, follows, ramps, integrates,"
            " counts, wanders, replays",
        ),
        (
            "values: {Voltage: {value: 1, counts: 1}}",
            "3:19: value and counts at once: a value has one of value, follows, ramps,"
            " integrates, counts, wanders, replays",
        ),
        (
            "values: {Voltage: {value: 1, rate: 1}}",
            "3:36: 'rate' stands beside 'ramps' only",
        ),
        ("values: {Voltage: {ramps: 1}}", "3:27: 'ramps' stands beside 'rate' only"),
        (
            "values: {Voltage: {follows: Curent}}",
            "3:29: unknown setting or object 'Curent': did you mean 'Current'?",
        ),
        (
            "values: {Voltage: {follows: 0x2099}}",
            None,  # a number
        ),
        (
            "values: {Voltage: {value: lod}}\nsettings: {load: {default: 1}}",
            "3:27: unknown setting 'lod': did you mean 'load'?",
        ),
        (
            "values: {Voltage: {value: 1, noise: -1}}",
            "3:37: -1 is less than 0",
        ),
        ("values: {Voltage: {counts: 1, every: 0}}", "3:38: 0 is less than 0.01"),
        (
            "values: {Voltage: {wanders: 1, low: 5, high: 1}}",
            "3:37: low is 5, above high, which is 1",
        ),
        ("values: {Voltage: {value: 1e19}}", "3:27: 1e19 is not in -1e+18..1e+18"),
        (
            "values: {0x1001: {value: 1}}",
            "3:10: 0x1001:00 is of the communication, which has it itself",
        ),
        (
            "values: {Voltage: {value: 1}, 0x2001: {value: 2}}",
            "3:31: line 3 says already how this object moves",
        ),
        ("values: {}", "3:9: empty; at least one key with a value is wanted here"),
        (
            "values: {Voltage: {replays: no.csv}}",
            "3:29: no.csv: No such file or directory",
        ),
        (
            "settings: {node_id: {default: 1}}",
            "3:12: every device of this kind has a setting 'node_id'",
        ),
        (
            "settings: {Voltage: {default: 1}}",
            "3:12: 'Voltage' is the name of an object, too: take another",
        ),
        (
            "settings: {a load: {default: 1}}",
            "3:12: 'a load' is no name of a setting; they look like load_current",
        ),
        ("settings: {load: {low: 1}}", "3:18: 'default' is missing"),
        (
            "settings: {load: {default: 5, high: 1}}",
            "3:28: 5 is not between low and high",
        ),
        (
            "emergencies: {Hot: {code: 0x4210, while: {Voltage: {abov: 1}}}}",
            "3:53: unknown key 'abov': did you mean 'above'?",
        ),
        (
            "emergencies: {Hot: {code: 0x4210, while: {Voltage: {}}}}",
            "3:52: wanted is above, below or equals",
        ),
        ("emergencies: {Hot: {code: 0x4210}}", "3:20: 'while' is missing"),
        (
            "emergencies: {Hot: {code: 0, while: {Voltage: {above: 1}}}}",
            "3:27: 0 is not in 1..65535",
        ),
        (
            "faults: {stuck: {text: It hangs., hold: [Voltage]}}",
            "3:42: 'Voltage' is not among the values that move",
        ),
        ("faults: {stuck: {text: It hangs.}}", "3:17: wanted is hold, set or offset"),
        (
            "faults: {bad: {text: It lies., set: {Voltage: hig}}}\nsettings: {high: {default: 9}}",
            "3:47: unknown setting 'hig': did you mean 'high'?",
        ),
        (
            "profile: {blok: true}",
            "3:11: unknown key 'blok': did you mean 'block'?",
        ),
        ("profile: {block: 1}", "3:18: '1' is neither true nor false"),
        ("class: nothing", "3:8: 'nothing' is no module:Class, such as fan:Fan"),
        ("class: nothing:Fan", "3:8: nothing:Fan: No module named 'nothing'"),
        ("class: json:JSONDecoder", "3:8: json:JSONDecoder is no Device"),
        ("class: json:Fan", "3:8: json:Fan: module 'json' has no attribute 'Fan'"),
    ],
)
def test_a_mistake_has_its_place(write, text, line):
    path = write(text)
    if line is None:
        assert devices.find(str(path))
    else:
        assert told(path) == [f"{path.name}:{line}"]


def test_several_are_told_at_once(write):
    path = write(
        "values:\n  Voltag: {value: 1}\n  Current: {}\n"
        "emergencies:\n  Hot: {code: 0x4210, while: {Temp: {above: 1}}}"
    )
    assert [line.split(":")[1] for line in told(path)] == ["4", "5", "7"]


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ("time,x\n1,2\n3\n", "day.csv:3: wanted are seconds and a value, not '3'"),
        ("1,2\n0.5,2\n", "day.csv:2: 0.5 s is before the row above"),
        ("time,x\n", "day.csv: there is no row of seconds and a value"),
        ("1,nan\n", "day.csv:1: wanted are seconds and a value, not '1,nan'"),
    ],
)
def test_a_row_that_is_wrong_has_its_line(write, tmp_path, rows, words):
    (tmp_path / "day.csv").write_text(rows)
    path = write("values: {Voltage: {replays: day.csv}}")
    assert told(path) == [f"{path.name}:3:29: {words}"]


def test_a_column_that_is_not_there(write, tmp_path):
    (tmp_path / "day.csv").write_text("time,volts\n1,2\n")
    path = write("values: {Voltage: {replays: day.csv, column: volt}}")
    assert told(path)[0].endswith("day.csv: unknown column 'volt': did you mean 'volts'?")


def test_an_eds_that_is_not_there(tmp_path):
    path = tmp_path / "none.device.yaml"
    path.write_text("version: 1\neds: none.eds\n")
    assert told(path) == ["none.device.yaml:2:6: none.eds: No such file or directory"]


def test_another_version(write):
    path = write("")
    path.write_text(path.read_text().replace("version: 1", "version: 2"))
    assert told(path) == [
        f"{path.name}:1:10: version 2 is unknown; this program reads 1",
    ]


def test_check_says_it_as_of_scenarios(write, capsys):
    path = write("values: {Voltag: {value: 1}}")
    assert main(["check", str(path)]) == 2
    assert capsys.readouterr().err == (
        f"{path}:3:10: unknown object 'Voltag': did you mean 'Voltage'?\n"
    )
    assert main(["check", str(write("", "right.yaml"))]) == 0
    assert capsys.readouterr().out.endswith("right.yaml: ok\n")


def test_a_file_that_was_changed_is_read_anew(write, tmp_path):
    path = write("values: {Voltage: {replays: day.csv}}")
    for number in (1, 2):
        (tmp_path / "day.csv").write_text(f"0,{number}\n")
        os.utime(tmp_path / "day.csv", (number, number))
        assert Bench(str(path)).values("Voltage") == {"Voltage": number}
    assert devices.find(str(path)) is devices.find(str(path))


def test_a_path_is_told_as_it_was_given(write, monkeypatch, tmp_path, capsys):
    write("values: {Voltag: {value: 1}}")
    monkeypatch.chdir(tmp_path)
    assert main(["check", "battery.device.yaml"]) == 2
    assert capsys.readouterr().err.startswith("battery.device.yaml:3:10: ")


def test_check_says_what_is_unusual_in_its_eds(write, tmp_path, capsys):
    path = write("")
    eds = tmp_path / "battery.eds"
    eds.write_text(eds.read_text().replace("ProductNumber=0x00000003", "ProductNumber="))
    assert main(["check", str(path)]) == 0
    told = capsys.readouterr().out.splitlines()
    assert "battery.eds:18: [DeviceInfo] ProductNumber is empty" in told[0]
    assert told[1] == f"{path}: ok, with 1 remark"


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*/*.device.yaml")), ids=lambda it: it.name)
def test_the_json_schema_takes_what_we_take(path, capsys):
    assert main(["schema", "device"]) == 0
    schema = json.loads(capsys.readouterr().out)
    content = yaml.safe_load(path.read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(content, schema)
    content["values"] = {"Voltage": {"value": 1, "rate": 2}}
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(content, schema)


def test_the_reference_has_every_key():
    page = (EXAMPLES.parent / "reference" / "device-files.md").read_text("utf-8")
    tables = [device_file.DeviceFile, *device_file.Table.__subclasses__()]
    ours = [table for table in tables if table.__module__ == device_file.__name__]
    assert len(ours) == 7
    keys = {field.alias or name for table in ours for name, field in table.model_fields.items()}
    assert [key for key in sorted(keys) if not re.search(rf"[`{{ ]{key}\b", page)] == []
