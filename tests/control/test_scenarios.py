"""A scenario that is started by the control port while its nodes run."""

import time

import pytest

from .served import PATIENCE

STORY = """\
version: 1
node: {device: topcon, node_id: 5}
steps:
  - {at: 0, inject: interlock_open}
  - {at: 0, expect: {emcy: any, within: 0.5}}
cleanup:
  - clear: interlock_open
  - power: "off"
  - power: "on"
"""
ENDLESS = """\
version: 1
node: {device: topcon, node_id: 5}
steps:
  - {at: 60, inject: interlock_open}
cleanup:
  - inject: heartbeat_stopped
"""


def over(port):
    """The verdict, when there is one."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        told = port.get("/scenario").body
        if not told["running"]:
            return told
    raise AssertionError(told)


def test_a_scenario_is_played_and_judged_once_and_again(port):
    for _ in range(2):
        status, _ = port("POST", "/scenario", {"name": "trip.yaml", "text": STORY})
        assert status == 200
        told = over(port)
        assert (told["verdict"], told["file"]) == ("PASS", "trip.yaml")
        assert [outcome["verdict"] for outcome in told["outcomes"]] == ["PASS"]
        assert port.get("/nodes/topcon").body["faults"] == []


def test_it_tells_what_it_does(port):
    with port.events("?kind=inject&kind=outcome&kind=clear") as events:
        port("POST", "/scenario", {"text": STORY})
        told = [next(events) for _ in range(3)]
    assert [(event["kind"], event["node"]) for event in told] == [
        ("inject", "topcon"),
        ("outcome", "topcon"),
        ("clear", "topcon"),
    ]
    assert told[1]["details"]["verdict"] == "PASS"
    over(port)


def test_it_can_be_stopped_and_there_is_one_at_a_time(port):
    assert port("POST", "/scenario", {"text": ENDLESS}).status == 200
    assert port.get("/scenario").body["running"] is True
    answer = port("POST", "/scenario", {"text": STORY})
    assert answer == (422, {"detail": "scenario.yaml is not over yet: stop it first"})
    assert port("DELETE", "/scenario").status == 200
    assert over(port)["verdict"] == "ERROR"
    assert port.get("/nodes/topcon").body["faults"][0]["name"] == "heartbeat_stopped"
    assert port("DELETE", "/scenario") == (422, {"detail": "no scenario is running"})


@pytest.mark.parametrize(
    ("body", "detail"),
    [
        ({"name": "topcon_overvoltag.yaml"}, "did you mean 'topcon_overvoltage.yaml'?"),
        ({"name": "../x/a.yaml", "text": "version: 1\n"}, "a.yaml:1:1: "),
        ({"text": STORY.replace("interlock_open", "interlock_opn", 1)}, "scenario.yaml:4:21: "),
        (
            {
                "text": STORY.replace("node:", "nodes:")
                .replace("{device", "{x: {device")
                .replace("id: 5}", "id: 5}}")
            },
            "scenario.yaml",
        ),
        ({"text": STORY.replace("topcon", "charger")}, "scenario.yaml"),
        ({"text": "version: 1\nnode: {device: other.eds}\nsteps: []\n"}, "no node that runs is"),
        ({"text": 5}, "body.text: Input should be a valid string"),
    ],
)
def test_one_that_cannot_be_played_here_is_refused(port, body, detail):
    answer = port("POST", "/scenario", body)
    assert answer.status == 422
    assert detail in answer.body["detail"]
    assert "/tmp" not in answer.body["detail"]


def test_one_for_the_device_of_a_file_is_found_by_the_name_of_the_file(port):
    text = (
        "version: 1\nnodes: {battery: {device: battery.device.yaml, node_id: 9}}\n"
        "steps: [{at: 0, node: battery, expect: {nmt_state: pre-operational}}]\n"
    )
    answer = port("POST", "/scenario", {"text": text})
    assert answer.status in (200, 422), answer
    if answer.status == 200:
        assert over(port)["verdict"] == "PASS"


def test_it_is_about_the_node_of_its_name_with_a_second_device_on_the_bus(port):
    port("POST", "/nodes/topcon/faults/duplicate_node_id")
    port("POST", "/scenario", {"text": STORY.partition("cleanup:")[0]})
    assert over(port)["verdict"] == "PASS"
    names = [fault["name"] for fault in port.get("/nodes/topcon").body["faults"]]
    assert names == ["duplicate_node_id", "interlock_open"]
