"""What the control port tells of a node, so complete that a page can be made from it."""

from urllib.parse import quote

import pytest

from canopen_twins import Bench

from .conftest import BATTERY

DEVICES = {"topcon": "topcon", "engine": "gateway", "battery": BATTERY}


@pytest.fixture(params=DEVICES)
def node(request):
    return request.param


def test_every_setting_is_declared_with_its_value(port, node):
    status, told = port.get(f"/nodes/{node}/settings")
    assert status == 200
    settings = Bench(DEVICES[node]).twin.settings
    assert [setting["name"] for setting in told] == list(settings)
    by_name = {setting["name"]: setting for setting in told}
    assert by_name["timing"]["choices"] == ["ideal", "typical", "worst"]
    assert by_name["store_time"]["optional"] is True
    assert by_name["store_time"]["unit"] == "s"
    assert (by_name["store_time"]["low"], by_name["store_time"]["high"]) == (0, 3600)


def test_a_setting_says_whether_it_is_live_and_who_assumed_it(port):
    told = {setting["name"]: setting for setting in port.get("/nodes/topcon/settings").body}
    assert told["load"]["live"] is True
    assert told["node_id"] == {
        "name": "node_id",
        "value": 5,
        "default": 1,
        "text": "node id the device is delivered with, 1..127",
        "type": "integer",
        "choices": [],
        "optional": False,
        "unit": "",
        "low": None,
        "high": None,
        "assumed": told["node_id"]["assumed"],
        "live": False,
    }
    port("PATCH", "/nodes/topcon/settings", {"load": "resistor 7"})
    told = {setting["name"]: setting for setting in port.get("/nodes/topcon/settings").body}
    assert told["load"]["value"] == "resistor 7"


def test_every_fault_is_declared_with_its_parameters(port, node):
    status, told = port.get(f"/nodes/{node}/faults")
    assert status == 200
    known = Bench(DEVICES[node]).twin.node.faults.known
    assert list(told["known"]) == list(known)
    for name, fault in known.items():
        assert told["known"][name]["text"] == fault.text
        assert list(told["known"][name]["parameters"]) == list(fault.parameters)
    assert told["known"]["heartbeat_late"]["parameters"]["seconds"] == {
        "text": known["heartbeat_late"].parameters["seconds"].text,
        "type": "number",
        "default": known["heartbeat_late"].parameters["seconds"].default,
        "low": 0,
        "high": told["known"]["heartbeat_late"]["parameters"]["seconds"]["high"],
    }
    assert told["active"] == []


def test_a_form_filled_in_as_declared_is_taken(port):
    known = port.get("/nodes/topcon/faults").body["known"]
    for name in ("heartbeat_stopped", "sdo_late", "frame_lost"):
        parameters = {
            key: told["default"]
            for key, told in known[name]["parameters"].items()
            if told["default"] is not None
        }
        assert port("POST", f"/nodes/topcon/faults/{name}", parameters).status == 200
    assert len(port.get("/nodes/topcon/faults").body["active"]) == 3


def test_values_are_had_by_name_and_by_address(port):
    told = port.get(f"/nodes/topcon/values?name={quote('Device Type')}&name=0x1018:01").body
    assert list(told) == ["Device Type", "0x1018:01"]


def test_without_a_name_all_values_are_told(port, node):
    bench = Bench(DEVICES[node])
    bench.run(1)
    assert list(port.get(f"/nodes/{node}/values").body) == list(bench.twin.values())


def test_every_object_is_told_with_its_section(port):
    told = {each["name"]: each for each in port.get("/nodes/topcon/objects").body}
    command = told["Run command"]
    assert command["address"] == "0x2014:00"
    assert command["access"] == "rw"
    assert command["section"]


def test_what_a_file_measures_can_be_set(port):
    assert port("PATCH", "/nodes/battery/settings", {"0x1018:03": 7}).status == 200
    assert port.get("/nodes/battery/values?name=0x1018:03").body == {"0x1018:03": 7}


def test_curves_and_state_of_a_device_are_told(port):
    told = port.get("/nodes/topcon").body
    assert [(curve["label"], curve["unit"]) for curve in told["curves"]][:2] == [
        ("Voltage", "V"),
        ("Current", "A"),
    ]
    assert told["band"]["label"] == "ready"


@pytest.mark.parametrize(
    ("path", "status", "detail"),
    [
        ("values?name=Device%20tipe", 422, "did you mean 'Device Type'?"),
        ("values?name=0x9999:00", 422, "unknown object '0x9999:00'"),
        ("why?frame=xyz", 422, "xyz"),
        ("why?frame=123%23", 422, "123# is not among the last"),
        ("why?object=Run%20comand", 422, "did you mean 'Run command'?"),
        ("whi", 404, "unknown node 'topcon/whi'"),
    ],
)
def test_what_is_not_there_is_told(port, path, status, detail):
    answer = port.get(f"/nodes/topcon/{path}")
    assert answer.status == status
    assert detail in answer.body["detail"]
