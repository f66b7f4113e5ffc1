from scenarios.trip import SPEEDS
from simulators.pump import flow


def test_modules_of_the_project_are_found():
    assert [flow(speed) for speed in SPEEDS] == [0, 15, 30]


def test_a_device_has_its_fixture(topcon):
    topcon.sdo["Voltage reference"].raw = 2000
    assert topcon.values("Voltage reference") == {"Voltage reference": 2000}


def test_a_bench_of_two_is_made(canopen_bench):
    bench = canopen_bench.of({"left": ("topcon", 5), "right": ("charger", 6)})
    assert bench.sent == ["705#00", "706#00"]


def test_a_scenario_of_the_project_is_played(canopen_scenario):
    assert canopen_scenario("../scenarios/boot.twin.yaml").run(1.0) == []


def test_a_twin_in_real_time_is_there(canopen_device):
    twin = canopen_device("topcon", node_id=5)
    twin.inject("error", number=0x23)
    assert (twin.node_id, twin.report["state"]) == (5, "ERROR")
