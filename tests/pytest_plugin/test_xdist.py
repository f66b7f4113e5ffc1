from .steps import BROKEN, FAILING, PASSING

SUITE = """
    import can
    import canopen
    import pytest
    from canopen_twins.slave.dictionary import dictionary

    canopen.Network.NOTIFIER_CYCLE = 0.01

    @pytest.mark.parametrize("node_id", range(1, 5))
    def test_bench(canopen_bench, node_id):
        assert canopen_bench("topcon", node_id=node_id).sent == [f"70{node_id}#00"]

    @pytest.mark.parametrize("voltage", [1000, 2000])
    def test_device(canopen_device, voltage):
        served = canopen_device("topcon", node_id=5)
        with canopen.Network().connect(**served.bus) as network:
            node = network.add_node(5, dictionary("topcon.eds", 5))
            node.sdo["Voltage reference"].raw = voltage
            assert node.sdo["Voltage reference"].raw == voltage

    def test_simulated(charger, canopen_simulated_time):
        canopen_simulated_time(charger)

    @pytest.mark.parametrize("file", ["good.yaml", "bad.yaml", "topcon_overvoltage.yaml"])
    def test_story(canopen_scenario, file):
        canopen_scenario(file)

    @pytest.mark.parametrize("run", [1, 2])
    def test_process(canopen_process, canopen_hub, run):
        twin = canopen_process("topcon", node_id=5)
        assert twin.ready["hub"] == str(canopen_hub.hub)
        with can.Bus(**twin.bus) as bus:
            bus.send(can.Message(arbitration_id=0x605, is_extended_id=False, data=[0x40] + 7 * [0]))
            assert bus.recv(30).arbitration_id == 0x585

    def test_each(topcon, gateway):
        assert topcon.sent != gateway.sent
"""


def test_every_fixture_and_every_story_can_be_spread_over_processes(pytester, story):
    pytester.makepyfile(SUITE)
    story("good.yaml", PASSING)
    story("bad.yaml", FAILING)
    for number in range(3):
        story(f"good{number}.twin.yaml", PASSING, f"Good {number}")
    story("bad.twin.yaml", FAILING)
    story("broken.twin.yaml", BROKEN)
    result = pytester.runpytest_subprocess("-n2", "-p", "no:cacheprovider")
    result.assert_outcomes(passed=15, failed=2, errors=1)
    result.stdout.fnmatch_lines(["*bad.twin.yaml: FAIL (1 FAIL)"])
