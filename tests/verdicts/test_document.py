import json

from canopen_twins.scenario import Verdict
from canopen_twins.scenario.verdict import as_json


def test_it_has_everything_a_verdict_has(verdict):
    told = json.loads(as_json([verdict]))
    assert told.keys() == {"version", "verdict", "scenarios"}
    assert (told["version"], told["verdict"]) == (1, "ERROR")
    (scenario,) = told["scenarios"]
    outcomes = scenario.pop("outcomes")
    assert scenario == {
        "file": "stories/all.yaml",
        "name": "Everything at once",
        "verdict": "ERROR",
        "seed": 7,
        "duration": 12.5,
    }
    assert outcomes[1] == {
        "verdict": "FAIL",
        "time": 0.25,
        "line": 6,
        "what": "no EMCY for 1 s",
        "seen": "2300/03/23",
        "note": "A note.",
        "node": "topcon",
        "scene": verdict.outcomes[1].scene,
    }
    assert [each["verdict"] for each in outcomes] == ["PASS", "FAIL", "ERROR", "ERROR", "SKIP"]


def test_its_verdict_is_the_worst_of_several(verdict):
    good = Verdict("good.yaml", ())
    assert json.loads(as_json([good]))["verdict"] == "PASS"
    assert json.loads(as_json([good, verdict, good]))["verdict"] == "ERROR"


def test_it_is_one_line(verdict):
    assert "\n" not in as_json([verdict])
