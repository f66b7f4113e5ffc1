import subprocess
import sys
import time
from pathlib import Path

REAL_TIME = """
    from threading import Event

    import canopen
    import pytest

    @pytest.fixture
    def master(canopen_device, monkeypatch):
        monkeypatch.setattr(canopen.Network, "NOTIFIER_CYCLE", 0.01)
        served = canopen_device("topcon", node_id=5, load="resistor 4")
        with canopen.Network().connect(**served.bus) as network:
            from canopen_twins.slave.dictionary import dictionary

            yield served, network.add_node(5, dictionary("topcon.eds", 5))
"""


def test_a_bench_is_made_with_the_settings_it_is_asked_for(run):
    run("""
        def test_boots(canopen_bench):
            assert canopen_bench("topcon", node_id=29).sent == ["71D#00"]

        def test_two_on_one_bus(canopen_bench):
            bench = canopen_bench.of({"left": ("topcon", 5), "right": ("topcon", 6)})
            assert bench.sent == ["705#00", "706#00"]
    """).assert_outcomes(passed=2)


def test_every_device_has_a_fixture_and_every_test_a_fresh_one(run):
    run("""
        def test_first(topcon):
            topcon.sdo["Voltage reference"].raw = 7

        def test_second(topcon):
            assert topcon.sdo["Voltage reference"].raw == 0
    """).assert_outcomes(passed=2)


def test_the_fixtures_are_listed_with_what_they_are(run):
    result = run("", "--fixtures")
    result.stdout.fnmatch_lines_random(
        [
            "canopen_bench*",
            "canopen_device*",
            "canopen_hub*",
            "canopen_process*",
            "canopen_simulated_time*",
            "topcon*",
        ]
    )


def test_a_failing_test_shows_the_last_frames_in_words_the_faults_and_the_device(run):
    result = run("""
        def test_fails(topcon):
            topcon.inject("lasting_error", number=0x23)
            assert topcon.send("601#4014200000000000") == []
    """)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "*CANopen: last frames and devices*",
            "*topcon*701#00*boot-up",
            "*topcon*081#0023032300000000*EMCY 2300h register 03h gate driver A fault",
            "*-*601#4014200000000000*SDO read 0x2014:00 Run command",
            "topcon: node 1, PRE-OPERATIONAL",
            "*faults: lasting_error(number=35)",
            "*state: ERROR",
        ]
    )


def test_a_passing_test_shows_nothing(run):
    result = run("def test_passes(topcon): pass", "-rA")
    result.stdout.no_fnmatch_line("*last frames*")


def test_a_master_is_taken_to_simulated_time_until_the_end_of_the_test(run, pytester):
    pytester.makepyfile(
        supply="""
        import time
        import canopen

        def nominal_voltage(eds):
            with canopen.Network().connect(interface="socketcan", channel="can0") as network:
                time.sleep(1000)
                return network.add_node(1, eds).sdo["Nominal voltage"].raw
        """
    )
    run("""
        import supply
        from time import sleep
        from canopen_twins.slave.dictionary import dictionary

        def test_simulated(topcon, canopen_simulated_time):
            canopen_simulated_time(topcon, "supply")
            assert supply.nominal_voltage(dictionary("topcon.eds", 1)) == 400
            assert topcon.clock.now > 1000

        def test_real():
            assert supply.time.sleep is sleep
    """).assert_outcomes(passed=2)


def test_a_served_device_answers_a_master_in_real_time(run):
    run(
        REAL_TIME
        + """
    def test_answers(master):
        served, node = master
        assert node.sdo["Nominal voltage"].raw == 400

    def test_does_what_it_is_asked(master):
        served, node = master
        served.inject("lasting_error", number=0x23)
        assert node.sdo["Error Register"].raw == 0x03
        assert (served.state, served.report["state"]) == ("PRE-OPERATIONAL", "ERROR")
        assert served.values("Error Register") == {"Error Register": 0x03}
        served.clear("lasting_error")
        node.sdo["Run command"].raw = 2
        assert node.sdo["Error Register"].raw == 0x00
        with pytest.raises(ValueError, match="did you mean 'error'"):
            served.inject("eror")

    def test_boots_again_after_its_power_was_off(master):
        served, node = master
        booted = Event()
        node.network.subscribe(0x705, lambda *_: booted.set())
        served.power_off()
        served.power_on(load="resistor 8")
        assert booted.wait(30)
        with pytest.raises(ValueError, match="the power is on"):
            served.power_on(load="resistor 4")
    """
    ).assert_outcomes(passed=3)


def test_the_bus_is_chosen_by_an_option_or_an_ini_key(run, pytester):
    source = """
        def test_bus(canopen_device):
            assert canopen_device("topcon").bus == {"interface": "virtual", "channel": "here"}
    """
    run(source, "--canopen-interface=virtual", "--canopen-channel=here").assert_outcomes(passed=1)
    pytester.makeini("[pytest]\ncanopen_channel = here")
    run(source).assert_outcomes(passed=1)


def test_a_device_that_cannot_be_had_fails_the_test_in_one_line(run):
    result = run("def test_none(canopen_device): canopen_device('topkon')")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*UserError: unknown device 'topkon': did you mean 'topcon'?"])


def test_a_bus_that_cannot_be_opened_fails_the_test(run):
    source = "def test_none(canopen_device): canopen_device('topcon')"
    result = run(source, "--canopen-interface=nonsense")
    result.assert_outcomes(failed=1)


def test_a_bug_in_a_served_twin_fails_the_test(run):
    result = run(
        REAL_TIME
        + """
    def test_bug(master):
        served, node = master
        served._node.device.stage.run = {}.popitem
        with pytest.raises(canopen.SdoCommunicationError):
            node.sdo["Run command"].raw = 1
        served._thread.join()
        with pytest.raises(RuntimeError, match="twin topcon has stopped"):
            served.clear()
    """
    )
    result.assert_outcomes(passed=1, errors=1)
    result.stdout.fnmatch_lines(["*KeyError*"])


def test_loading_the_plugin_imports_nothing_of_can():
    code = (
        "import sys, canopen_twins.pytest_plugin; "
        "print([name for name in ('can', 'canopen', 'yaml') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_sleep_of_the_test_itself_is_told(run):
    run("""
        from time import sleep

        def test_it(topcon, canopen_simulated_time):
            canopen_simulated_time(topcon)
            sleep(1)
    """).stdout.fnmatch_lines(["*time.sleep would wait in real time, at *in test_it: name that*"])


def test_a_master_that_opens_a_real_bus_beside_a_bench_is_told_of_simulated_time(run):
    result = run("""
        import canopen

        def test_it(topcon):
            canopen.Network().connect(interface="socketcan", channel="no_such_bus")
    """)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*canopen_simulated_time(bench, 'my_master')*"])


IN_A_PROCESS = """
    import can
    import pytest

    def ask(bus, node_id):
        read = bytes.fromhex("4000100000000000")
        bus.send(can.Message(arbitration_id=0x600 + node_id, is_extended_id=False, data=read))
        return bus.recv(30).arbitration_id - 0x580

    def test_twins_share_the_bus_of_a_test(canopen_process, canopen_hub):
        left, right = canopen_process("topcon", node_id=5), canopen_process("charger", node_id=6)
        with can.Bus(**canopen_hub.options) as bus:
            assert [ask(bus, 5), ask(bus, 6)] == [5, 6]
        assert left.bus == right.bus
        with pytest.raises(ValueError, match="node 5 is on test1 already"):
            canopen_process("topcon", node_id=5)
        assert (right.end(), right.errors) == (0, "")

    def test_a_scenario_is_judged_there(canopen_process):
        twin = canopen_process(scenario="trip.yaml")
        assert twin.ready["nodes" if "nodes" in twin.ready else "node_id"] == 5
        assert twin.wait() == 0
        assert "trip.yaml: PASS (1 PASS)" in twin.output

    def test_that_fails_shows_what_the_twins_said(canopen_process):
        assert not canopen_process("topcon", load="open").ready
"""


def test_twins_in_a_process_of_their_own_are_on_a_bus_of_the_test(run, story):
    story("trip.yaml", "- {at: 0, expect: {value: {0x1000: 0}}}")
    result = run(IN_A_PROCESS)
    result.assert_outcomes(passed=2, failed=1)
    result.stdout.fnmatch_lines(["*CANopen: last frames and devices*", '{"ready": "topcon"*'])


def test_processes_of_a_run_of_pytest_that_was_killed_do_not_outlive_it(pytester):
    pytester.makepyfile("""
        import os, signal
        from pathlib import Path

        def test_it(canopen_process, canopen_hub):
            twin = canopen_process("topcon")
            children = Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text()
            Path("children").write_text(children)
            os.kill(os.getpid(), signal.SIGKILL)
    """)
    pytester.runpytest_subprocess("-p", "no:cacheprovider")
    children = (pytester.path / "children").read_text().split()
    assert len(children) == 2
    end = time.monotonic() + 30
    while any(Path("/proc", child, "exe").exists() for child in children):
        assert time.monotonic() < end
        time.sleep(0.01)
