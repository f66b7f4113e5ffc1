import filecmp
import json

import pytest

from canopen_twins import scenario as replay
from canopen_twins.files.shipped import scenario_file
from canopen_twins.record.folder import record
from canopen_twins.record.manifest import Manifest

from .conftest import STORY

FILES = ["events.jsonl", "run.json", "scenario.yaml", "trace.log"]


def events(folder):
    return [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]


def test_a_record_holds_the_run_the_scenario_the_frames_and_the_events(said, story, tmp_path):
    code, out, _ = said("play", "--raw", story(), "--record", tmp_path / "record")
    assert code == 0
    folder = tmp_path / "record"
    assert sorted(path.name for path in folder.iterdir()) == FILES
    assert (folder / "scenario.yaml").read_text() == STORY
    assert out.startswith((folder / "trace.log").read_text())
    told = json.loads((folder / "run.json").read_text())
    assert (told["format"], told["kind"], told["seed"]) == (1, "play", 1)
    assert told["scenario"] == str(tmp_path / "story.yaml")
    (node,) = told["nodes"]
    assert (node["name"], node["device"], node["settings"]["load"]) == (
        "topcon",
        "topcon",
        "resistor 4",
    )
    assert sorted(told["versions"]) == ["canopen", "canopen-twins", "python", "python-can"]


def test_two_records_of_the_same_play_are_the_same_to_the_byte(recorded):
    first, second = recorded(name="first"), recorded(name="second")
    assert filecmp.cmpfiles(first, second, FILES, shallow=False) == (FILES, [], [])


def test_the_keys_of_every_line_are_sorted(recorded):
    for line in (recorded() / "events.jsonl").read_text().splitlines():
        assert line == json.dumps(json.loads(line), sort_keys=True)


def test_a_record_of_a_shipped_scenario_has_its_text(said, tmp_path):
    assert said("play", "topcon_overvoltage.yaml", "--record", tmp_path / "record")[0] == 0
    with scenario_file("topcon_overvoltage.yaml") as shipped:
        assert filecmp.cmp(tmp_path / "record" / "scenario.yaml", shipped, shallow=False)


def test_what_is_printed_is_the_same_with_a_record(said, story, tmp_path):
    plain = said("play", story())
    assert said("play", story(), "--record", tmp_path / "record") == plain


def test_states_and_emergencies_are_events(recorded):
    told = [
        (event["time"], event["kind"], event.get("state") or event["words"])
        for event in events(recorded())
        if event["kind"] in ("state", "emcy")
    ]
    assert (0.0, "state", "pre-operational") in told
    assert (0.4, "state", "operational") in told
    (emcy,) = [words for time, kind, words in told if kind == "emcy" and time == 0.2]
    assert emcy.startswith("EMCY 2300h register")


def test_a_record_may_go_to_an_empty_directory(said, story, tmp_path):
    (tmp_path / "record").mkdir()
    assert said("play", story(), "--record", tmp_path / "record")[0] == 0
    assert (tmp_path / "record" / "run.json").exists()


REFUSED = [
    (lambda path: (path / "record" / "old").mkdir(parents=True), "exists: a record has a"),
    (lambda path: (path / "record").write_text("x"), "exists: a record has a directory of its own"),
    (lambda path: (path / "record.part").mkdir(), "is left of a run that has not ended: remove it"),
]


@pytest.mark.parametrize(("prepare", "told"), REFUSED, ids=["full", "file", "part"])
def test_a_record_replaces_nothing(said, story, tmp_path, prepare, told):
    prepare(tmp_path)
    code, out, err = said("play", story(), "--record", tmp_path / "record")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert told in err


def test_a_directory_that_is_full_may_be_the_one_we_are_in(said, story, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, _, err = said("play", story(), "--record", ".")
    assert (code, err) == (2, "canopen-twin: . exists: a record has a directory of its own\n")


def test_where_there_is_no_directory_there_is_no_record(said, story, tmp_path):
    code, _, err = said("play", story(), "--record", tmp_path / "nowhere" / "record")
    assert code == 2
    assert err.endswith("nowhere/record cannot be written: No such file or directory\n")


def test_only_one_run_at_a_time_can_be_kept(said, story, tmp_path):
    for option in ("--record", "--trace"):
        code, out, err = said("play", story(), story(), option, tmp_path / "kept.log")
        assert (code, out) == (2, "")
        assert "keeps one run" in err


def test_a_run_that_is_cut_short_leaves_a_part(story, tmp_path):
    def interrupt():
        raise KeyboardInterrupt

    def come(segment, player):
        segment.clock.at(0.3, interrupt)

    scenario = replay.load(story())
    told = Manifest.of(
        "play", scenario, {name: spec.create() for name, spec in scenario.nodes.items()}
    )
    with pytest.raises(KeyboardInterrupt), record(tmp_path / "record", told, b"") as observer:
        replay.play(scenario, observers=[observer, come])
    assert not (tmp_path / "record").exists()
    part = tmp_path / "record.part"
    assert (part / "trace.log").read_text().startswith("(0000000000.000000) can0 705#00\n")
    assert events(part)[-1]["time"] == 0.2
    assert "end" not in [event["kind"] for event in events(part)]


def test_a_run_that_never_began_leaves_nothing(said, tmp_path):
    bus = ("-i", "slcan", "-c", "/nowhere", "--real-bus")
    kept = ("--record", tmp_path / "record", "--trace", tmp_path / "trace.log")
    assert said("run", "topcon", *bus, *kept)[0] == 2
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "trace.log").write_text("older")
    assert said("run", "topcon", *bus, *kept)[0] == 2
    assert [path.read_text() for path in tmp_path.iterdir()] == ["older"]
