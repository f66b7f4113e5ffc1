import json
from importlib.metadata import version

import pytest

from .conftest import edit

LOOK = """\
version: 1
node: {device: topcon, node_id: 5}
steps:
  - {at: 0.1, send: "605#4018100400000000"}
"""


def test_a_play_is_lived_through_again(said, recorded):
    folder = recorded()
    trace = (folder / "trace.log").read_text()
    code, out, err = said("replay", folder)
    assert (code, out) == (0, trace)
    frames = len(trace.splitlines())
    events = len((folder / "events.jsonl").read_text().splitlines())
    assert err == f"the same {frames} frames and {events} events\n"


@pytest.mark.parametrize("suffix", ["png", "svg", "html"])
def test_it_is_drawn_as_it_was_when_it_was_played(said, story, tmp_path, suffix):
    then, now = tmp_path / f"then.{suffix}", tmp_path / f"now.{suffix}"
    said("play", story(), "--record", tmp_path / "record", "--plot", then)
    plain = said("replay", tmp_path / "record")
    assert said("replay", tmp_path / "record", "--plot", now) == plain
    assert plain[0] == 0
    assert now.read_bytes() == then.read_bytes()


def test_a_replay_that_differs_is_drawn_as_well(said, recorded, tmp_path):
    folder = recorded()
    edit(folder / "scenario.yaml", "number: 0x23", "number: 0x24")
    assert said("replay", folder, "--plot", tmp_path / "now.svg")[0] == 1
    assert "error(number=36)" in (tmp_path / "now.svg").read_text("utf-8")


def test_a_picture_with_no_place_is_told_before_anything_is_replayed(said, recorded):
    told = "canopen-twin: x.gif is no picture: its name ends with .html, .png, .svg\n"
    assert said("replay", recorded(), "--plot", "x.gif") == (2, "", told)


def test_the_scenario_is_that_of_the_record(said, recorded, story):
    folder = recorded()
    story("version: 2")
    assert said("replay", folder)[0] == 0


def test_a_shipped_scenario_is_called_as_it_was(said, tmp_path):
    said("play", "topcon_overvoltage.yaml", "--record", tmp_path / "record")
    assert said("replay", tmp_path / "record")[0] == 0


def test_settings_come_from_the_record(said, recorded):
    folder = recorded(LOOK)
    edit(folder / "run.json", '"serial": 1,', '"serial": 77,')
    code, out, _ = said("replay", folder)
    assert (code, out.count("585#431810044D000000")) == (1, 1)


def test_a_frame_that_comes_no_more_is_explained(said, recorded):
    folder = recorded()
    edit(folder / "scenario.yaml", "number: 0x23", "number: 0x24")
    code, _, err = said("replay", folder)
    assert code == 1
    lines = err.splitlines()
    assert lines[0] == "the first 3 frames are the same:"
    assert "record      0.200000  085#0023" in err
    assert "replay      0.200000  085#" in err
    assert "other data: byte 3 is 23 in record, 24 in replay" in lines


def test_what_is_written_otherwise_is_found(said, recorded):
    folder = recorded()
    edit(folder / "trace.log", "can0", "can1")
    code, _, err = said("replay", folder)
    assert code == 1
    assert err.endswith("trace.log has been written otherwise\n")


def test_an_event_that_is_another_one_is_explained(said, recorded):
    folder = recorded()
    edit(folder / "events.jsonl", '"state": "operational"', '"state": "stopped"')
    code, _, err = said("replay", folder)
    assert code == 1
    assert "but event " in err
    assert "record      0.400000  topcon      stopped" in err


def test_other_versions_are_told_before(said, recorded, caplog):
    folder = recorded()
    edit(folder / "run.json", f'"canopen": "{version("canopen")}"', '"canopen": "1.0"')
    assert said("replay", folder)[0] == 0
    assert caplog.messages == [f"{folder} was made with canopen 1.0 (now {version('canopen')})"]


MANY = """\
version: 1
seed: 7
bit_rate: 125000
nodes:
  right: {device: topcon, node_id: 6, settings: {br: 4}}
  left: {device: charger, node_id: 5}
steps:
  - {at: 0.3, node: right, inject: {heartbeat_jitter: {seconds: 0.05}}}
  - {at: 0.3, node: right, write: {Producer Heartbeat Time: 100}}
  - {at: 0.4, node: left, inject: {bus_load: {percent: 40, kilobits: 125}}, for: 0.2}
  - {when: {heartbeat: any, nth: 3}, node: right, nmt: start}
  - {after: 0.5, node: right, expect: {state: operational, within: 0.1}}
cleanup:
  - {after: 0.1, node: right, clear: all}
"""


def test_everything_a_scenario_can_do_is_lived_through_again(said, recorded, tmp_path):
    (tmp_path / "story.yaml").write_text(MANY)
    said("play", tmp_path / "story.yaml", "--record", tmp_path / "record")
    told = json.loads((tmp_path / "record" / "run.json").read_text())
    assert told["seed"] == 7
    assert [node["name"] for node in told["nodes"]] == ["right", "left"]
    trace = (tmp_path / "record" / "trace.log").read_text()
    assert trace.count(" 7FE#") > 20
    assert said("replay", tmp_path / "record")[:2] == (0, trace)


WRONG = [
    (lambda path: (path / "run.json").unlink(), "run.json: No such file or directory"),
    (lambda path: (path / "trace.log").unlink(), "trace.log is missing"),
    (lambda path: (path / "scenario.yaml").unlink(), "scenario.yaml is missing"),
    (lambda path: (path / "run.json").write_text("{"), "run.json is damaged: "),
    (lambda path: (path / "run.json").write_text("[]"), "run.json is damaged: "),
    (lambda path: (path / "run.json").write_bytes(b"\xff"), "run.json is damaged: "),
    (lambda path: edit(path / "run.json", '"format": 1', '"format": 2'), "format 2 is unknown"),
    (lambda path: edit(path / "run.json", '"format": 1', '"form": 1'), "is damaged: form: "),
    (lambda path: edit(path / "run.json", '"kind": "play"', '"kind": "sing"'), "kind: "),
    (lambda path: (path / "scenario.yaml").write_text("version: 2"), "scenario.yaml:1:"),
    (lambda path: (path / "trace.log").write_text("no frame\n"), "cannot be read as .log"),
    (lambda path: (path / "trace.log").write_bytes(b"\xff\xfe\n"), "cannot be read as .log"),
    (lambda path: (path / "events.jsonl").write_text("{}\n"), "events.jsonl:1 is damaged"),
    (lambda path: (path / "events.jsonl").write_text("[" * 5000), "events.jsonl:1 is damaged"),
    (lambda path: (path / "events.jsonl").write_bytes(b"\xff\n"), "events.jsonl: no UTF-8"),
]


@pytest.mark.parametrize(("damage", "told"), WRONG)
def test_a_damaged_record_is_told_in_a_line(said, recorded, damage, told):
    folder = recorded()
    damage(folder)
    code, _, err = said("replay", folder)
    assert code == 2
    lines = [line for line in err.splitlines() if "scenario.yaml:1:" not in line]
    assert len(lines) <= 1
    assert told in err


LINES = [
    '{"kind": "heard", "node": "", "time": -1}',
    '{"kind": "heard", "node": "", "time": NaN}',
    '{"kind": "heard", "node": "", "time": 1e400}',
    '{"kind": "heard", "node": "", "time": "x"}',
    '{"kind": 1, "node": "", "time": 1}',
    '{"kind": "heard", "time": 1}',
    '"heard"',
    "",
]


@pytest.mark.parametrize("line", LINES)
def test_a_damaged_event_is_told_with_its_line(said, live, tmp_path, line):
    live(lambda master: master.hear("701#00"), "topcon", "--record", tmp_path / "record")
    events = tmp_path / "record" / "events.jsonl"
    events.write_text(f'{{"kind": "state", "node": "", "time": 0}}\n{line}\n')
    code, _, err = said("replay", tmp_path / "record")
    assert (code, err) == (2, f"canopen-twin: {events}:2 is damaged: it is no event\n")


def test_a_frame_that_is_none_is_told_in_a_line(said, live, tmp_path):
    live(lambda master: master.hear("701#00"), "topcon", "--record", tmp_path / "record")
    events = tmp_path / "record" / "events.jsonl"
    events.write_text('{"kind": "heard", "node": "", "time": 0, "frame": "x"}\n')
    code, _, err = said("replay", tmp_path / "record")
    assert (code, err.count("\n")) == (2, 1)
    assert "'x' is no frame" in err


def test_what_is_no_directory_is_no_record(said, tmp_path):
    code, _, err = said("replay", tmp_path / "nothing")
    assert (code, err) == (
        2,
        f"canopen-twin: {tmp_path}/nothing is no record: a record is a directory\n",
    )


def test_a_file_that_a_setting_names_has_to_be_the_same(said, live, tmp_path):
    file = tmp_path / "gateway.yaml"
    file.write_text("version: 1\n")
    options = ("gateway", "--config", file, "--record", tmp_path / "record")
    assert live(lambda master: master.hear("7"), *options)[0] == 0
    told = json.loads((tmp_path / "record" / "run.json").read_text())
    assert list(told["files"]) == [str(file)]
    assert said("replay", tmp_path / "record")[0] == 0
    file.write_text("version: 1 \n")
    code, out, err = said("replay", tmp_path / "record")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert f"{file} is not what it was when" in err


def test_a_run_that_was_cut_short_can_be_lived_through_as_far(said, recorded):
    folder = recorded()
    lines = (folder / "events.jsonl").read_text().splitlines(keepends=True)
    (folder / "events.jsonl").write_text("".join(lines[:-1]))
    code, _, err = said("replay", folder)
    assert code == 1
    assert "record       no more events" in err


def test_an_event_of_a_kind_of_tomorrow_is_told_as_it_is(said, recorded):
    folder = recorded()
    edit(folder / "events.jsonl", '"kind": "state"', '"kind": "mood"')
    code, _, err = said("replay", folder)
    assert code == 1
    assert 'record      0.000000  topcon      mood {"state": "pre-operational"}' in err
