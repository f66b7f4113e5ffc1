"""What the control port takes and answers."""

import pytest


def test_nodes_are_told_in_their_order(port):
    status, nodes = port.get("/nodes")
    assert status == 200
    ids = [(node["name"], node["node_id"]) for node in nodes]
    assert ids == [("topcon", 5), ("engine", 1), ("battery", 9)]
    assert nodes[0]["state"] == "PRE-OPERATIONAL"
    assert nodes[0]["powered"] is True


def test_a_node_tells_how_it_is_by_its_name_and_by_its_node_id(port):
    by_name, by_id = port.get("/nodes/topcon").body, port.get("/nodes/5").body
    assert by_name["report"]["state"] == by_id["report"]["state"] == "READY"
    assert by_name["errors"] == []
    assert by_id["moment"] > by_name["moment"] > 0


def test_a_fault_comes_and_goes_at_a_moment_that_is_told(port):
    status, done = port("POST", "/nodes/topcon/faults/interlock_open")
    assert status == 200
    state = port.get("/nodes/topcon").body
    assert [fault["words"] for fault in state["faults"]] == ["interlock_open()"]
    assert [f"{error['code']:04X}h" for error in state["errors"]]
    assert state["moment"] > done["moment"]
    status, cleared = port("DELETE", "/nodes/topcon/faults/interlock_open")
    assert status == 200
    assert cleared["moment"] > state["moment"]
    assert port.get("/nodes/topcon").body["faults"] == []


def test_a_second_device_on_the_bus_is_no_node_to_be_named(port):
    before = [node["name"] for node in port.get("/nodes").body]
    port("POST", "/nodes/topcon/faults/duplicate_node_id")
    assert [node["name"] for node in port.get("/nodes").body] == before


def test_parameters_of_a_fault_come_in_the_body(port):
    port("POST", "/nodes/topcon/faults/heartbeat_late", {"seconds": 0.5})
    (fault,) = port.get("/nodes/topcon").body["faults"]
    assert fault["parameters"]["seconds"] == 0.5
    assert fault["words"] == "heartbeat_late(seconds=0.5)"


def test_the_load_can_be_changed(port):
    assert port("PATCH", "/nodes/topcon/settings", {"load": "resistor 4"}).status == 200


def test_the_supply_goes_and_comes_back_with_another_node_id(port):
    assert port("PUT", "/nodes/engine/power", {"on": False}).status == 200
    state = port.get("/nodes/engine").body
    assert (state["powered"], state["state"]) == (False, "INITIALISING")
    assert state["silence"] == "the node is silent: its supply is off"
    body = {"on": True, "settings": {"timing": "ideal"}}
    assert port("PUT", "/nodes/engine/power", body).status == 200
    assert port.get("/nodes/engine").body["powered"] is True


@pytest.mark.parametrize(
    ("method", "path", "body", "status", "detail"),
    [
        ("GET", "/nodes/topco", None, 404, "unknown node 'topco': did you mean 'topcon'?"),
        ("POST", "/nodes/topcon/faults/interlock", None, 404, "did you mean 'interlock_open'?"),
        ("DELETE", "/nodes/topcon/faults/interlock", None, 404, "did you mean 'interlock_open'?"),
        ("POST", "/nodes/topcon/faults/heartbeat_late", {"second": 1}, 422, "mean 'seconds'?"),
        ("POST", "/nodes/topcon/faults/heartbeat_late", {"name": 1}, 422, "unknown parameter of"),
        ("POST", "/nodes/topcon/faults/heartbeat_late", {"self": 1}, 422, "unknown parameter of"),
        ("PATCH", "/nodes/topcon/settings", {"self": 1}, 422, "unknown setting 'self'"),
        ("POST", "/nodes/topcon/faults/heartbeat_late", {"seconds": "x"}, 422, "wants a number"),
        ("POST", "/nodes/topcon/faults/heartbeat_late", {"seconds": [1]}, 422, "body.seconds"),
        ("POST", "/nodes/topcon/faults/heartbeat_late", [1], 422, "body: Input should be"),
        ("PATCH", "/nodes/topcon/settings", {"load": [1]}, 422, "body.load: a number, a text, "),
        ("POST", "/nodes/topcon/faults/heartbeat_late", b"{", 422, "body.1: JSON decode error"),
        ("POST", "/nodes/topcon/faults/heartbeat_late", b"[" * 9999, 400, "error parsing"),
        ("PATCH", "/nodes/topcon/settings", {"lode": 1}, 422, "did you mean 'load'?"),
        ("PATCH", "/nodes/topcon/settings", {"node_id": 7}, 422, "at power-on only"),
        ("PUT", "/nodes/topcon/power", {"on": "yes"}, 422, "body.on: Input should be"),
        ("PUT", "/nodes/topcon/power", {"on": True, "x": 1}, 422, "body.x: Extra inputs"),
        ("PUT", "/nodes/topcon/power", {"on": False, "settings": {"load": 1}}, 422, "comes"),
        ("PUT", "/nodes/topcon/power", {"on": True, "settings": {"load": 1}}, 422, "power is on"),
        ("GET", "/nothing", None, 404, "Not Found"),
        ("PUT", "/nodes", {}, 405, "Method Not Allowed"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(port, method, path, body, status, detail):
    answer = port(method, path, body)
    assert answer.status == status
    assert detail in answer.body["detail"]
    assert "\n" not in answer.body["detail"]


def test_it_describes_itself(port):
    told = port.get("/openapi.json").body
    assert "/nodes/{node}/faults/{fault}" in told["paths"]
    assert "moment" in told["components"]["schemas"]["Done"]["properties"]
