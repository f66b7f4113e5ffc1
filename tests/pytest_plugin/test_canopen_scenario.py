from .steps import BROKEN, FAILING, PASSING


def test_a_test_lives_through_a_story(run, story):
    story("trip.yaml", "- {at: 2, inject: {error: {number: 0x23}}}")
    run("""
        def test_trips(canopen_scenario):
            bench = canopen_scenario("trip.yaml")
            assert bench.sent == ["705#00"]
            assert bench.run(1.9) == []
            assert bench.run(0.2) == ["085#0023032300000000"]
            assert bench.done
            assert bench.verdict.ok
    """).assert_outcomes(passed=1)


def test_the_rest_of_the_story_decides_when_the_test_is_over(run, story):
    story("late.yaml", FAILING.replace("0.1", "3000"))
    result = run("def test_short(canopen_scenario): canopen_scenario('late.yaml').run(1)")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "late.yaml: FAIL (1 FAIL)",
            "  FAIL   3000.000000 s  late.yaml:5: topcon: Nominal voltage 401 at once: *is 400",
        ]
    )
    assert "Traceback" not in result.stdout.str()


def test_a_story_that_cannot_be_told_fails_the_test_and_is_told_apart(run, story):
    story("broken.yaml", BROKEN)
    result = run("def test_it(canopen_scenario): canopen_scenario('broken.yaml')")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["broken.yaml: ERROR (1 ERROR)"])


def test_a_test_that_fails_by_itself_says_so_and_how_the_bench_was(run, story):
    story("late.yaml", FAILING.replace("0.1", "3000"))
    result = run("""
        def test_it(canopen_scenario):
            assert canopen_scenario("late.yaml").sent == []
    """)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "*AssertionError*",
            "*CANopen: last frames*",
            "topcon: node 5*",
            "*CANopen: the scenario so far*",
            "late.yaml: ERROR (1 ERROR)",
            "* late.yaml:5: *: 1 step from here on was not reached",
        ]
    )
    result.stdout.no_fnmatch_line("*3000.0*")


def test_a_story_lies_beside_the_test_or_is_shipped(run, story, pytester):
    story("below/near.yaml", PASSING)
    pytester.mkdir("elsewhere")
    (pytester.path / "below" / "test_near.py").write_text("""
def test_near(canopen_scenario):
    canopen_scenario("near.yaml")
def test_shipped(canopen_scenario):
    assert canopen_scenario("topcon_overvoltage.yaml").run(2)
""")
    run(None, "below/test_near.py").assert_outcomes(passed=2)


def test_one_that_is_not_there_or_wrong_is_told_in_a_line_each(run, story):
    story("wrong.yaml", "- {at: 1, expct: 1}")
    result = run("""
        def test_none(canopen_scenario): canopen_scenario("topcon_overvoltag.yaml")
        def test_wrong(canopen_scenario): canopen_scenario("wrong.yaml")
    """)
    result.stdout.fnmatch_lines(
        [
            "unknown file or shipped scenario 'topcon_overvoltag.yaml': did you mean *",
            "wrong.yaml:5:11: unknown key 'expct': did you mean 'expect'?",
        ]
    )
    result.stdout.no_fnmatch_line("*Error*")


def test_the_master_of_the_test_is_alive_to_the_end_of_the_story(run, story, pytester):
    pytester.makepyfile(
        supervisor="""
        import threading, time
        import canopen

        def watch(eds):
            network = canopen.Network().connect(interface="socketcan", channel="can0")
            node = network.add_node(5, eds)

            def turn_off(error):
                stop.set()

            def loop():
                stop.wait()
                node.sdo["Run command"].raw = 0

            stop = threading.Event()
            node.emcy.add_callback(turn_off)
            threading.Thread(target=loop).start()
            node.sdo["Run command"].raw = 1
    """
    )
    story(
        "trip.yaml",
        """
        - {at: 10, inject: {error: {number: 0x23}}}
        - {at: 10, expect: {value: {Run command: 0}, within: 0.5}}
        """,
    )
    run("""
        import supervisor
        from canopen_twins.slave.dictionary import dictionary

        def test_gives_up(canopen_scenario, canopen_simulated_time):
            bench = canopen_scenario("trip.yaml")
            canopen_simulated_time(bench, "supervisor")
            supervisor.watch(dictionary("topcon.eds", 5))
    """).assert_outcomes(passed=1)


def test_a_story_may_have_several_twins(run, pytester):
    (pytester.path / "two.yaml").write_text("""\
version: 1
nodes:
  left: {device: topcon, node_id: 5}
  right: {device: topcon, node_id: 6}
steps:
  - {at: 1, node: left, inject: {error: {number: 0x23}}}
  - {at: 1, node: right, expect: {emcy: none, within: 1}}
""")
    run("""
        def test_one_trips(canopen_scenario):
            bench = canopen_scenario("two.yaml")
            bench.run(2)
            assert bench["left"].sdo["Error Register"].raw == 3
            assert bench["right"].sdo["Error Register"].raw == 0
    """).assert_outcomes(passed=1)


def test_a_reply_comes_after_what_it_replies_to(run, story):
    story(
        "reply.yaml",
        """
        - {at: 1, inject: {error: {number: 0x23}}}
        - {when: {emcy: any}, expect: {write: {Run command: 0}, within: 0.5}}
        """,
    )
    run("""
        def test_gives_up(canopen_scenario):
            bench = canopen_scenario("reply.yaml")
            errors = []
            bench.twin.remote.emcy.add_callback(errors.append)
            bench.run(1)
            if errors:
                bench.sdo["Run command"].raw = 0

        def test_goes_on(canopen_scenario):
            canopen_scenario("reply.yaml").run(1)
    """).assert_outcomes(passed=1, failed=1)


def test_frames_take_their_time_where_the_story_says_so(run, pytester):
    (pytester.path / "slow.yaml").write_text("""\
version: 1
bit_rate: 125000
node: {device: topcon, node_id: 5, settings: {br: 4}}
steps:
  - {at: 0, expect: {frame: "705#00", within: 0.01}}
""")
    run("""
        def test_boots(canopen_scenario):
            bench = canopen_scenario("slow.yaml")
            assert bench.sent == []
            assert bench.run(0.01) == ["705#00"]
    """).assert_outcomes(passed=1)


def test_a_master_that_waits_for_the_boot_up_message_gets_it(run, story):
    story("boot.yaml", "- {at: 0, power: off}\n- {at: 0.5, power: on}")
    run("""
        import canopen

        def test_waits(canopen_scenario, canopen_simulated_time):
            canopen_simulated_time(canopen_scenario("boot.yaml"))
            network = canopen.Network()
            network.connect(interface="socketcan", channel="can0")
            network.add_node(5).nmt.wait_for_bootup(1)
            network.disconnect()
    """).assert_outcomes(passed=1)
