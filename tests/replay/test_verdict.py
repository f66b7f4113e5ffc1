from canopen_twins.diagnosis.report import SHOWN
from canopen_twins.scenario import Kind, Outcome, Verdict, play


def test_kinds_are_kept_apart_and_the_worst_one_counts(story):
    passing, failing, broken = (
        "- {at: 1, expect: {emcy: none, within: 1}}\n",
        "- {at: 3, expect: {value: {Word: 0}}}\n",
        "- {at: 4, write: {Refusing: 1}}\n",
    )
    for steps, kind in (
        ("- {at: 1, nmt: stop}\n", Kind.PASS),
        (passing, Kind.PASS),
        (passing + failing, Kind.FAIL),
        (passing + failing + broken, Kind.ERROR),
    ):
        verdict = play(story(steps))
        assert (verdict.kind, verdict.ok) == (kind, kind is Kind.PASS)


def test_outcomes_stand_in_the_order_of_the_file(story):
    verdict = play(
        story(
            """\
            - {at: 1, expect: {emcy: none, within: 3}}
            - {at: 2, expect: {emcy: none, within: 1}}
            """
        )
    )
    assert [(each.line, each.time) for each in verdict.outcomes] == [(4, 4.0), (5, 3.0)]


def test_nothing_expected_is_said_to_be_so():
    assert str(Verdict("story.yaml", ())) == "story.yaml: PASS (nothing was expected)"


def test_a_verdict_reads_as_a_report(story):
    scenario = story(
        """\
        - {at: 0.5, inject: {error: {code: 0x1000, register: 3}}}
        - {at: 0.5, expect: {emcy: {code: 0x1000}, within: 0.1}}
        - at: 1
          note: It cannot be both.
          expect: {value: {Word: 0x05}}
        """
    )
    file = scenario.file
    assert str(play(scenario)).splitlines() == [
        f"{file}: FAIL (1 PASS, 1 FAIL)",
        f"  PASS      0.500000 s  {file}:5: probe: EMCY 1000/xx/xx within 0.1 s:"
        " 1000/03/646C656966",
        f"  FAIL      1.000000 s  {file}:6: probe: Word 0x0005 at once: Word is 0x1234",
        "        note: It cannot be both.",
        "            0.000000  probe       705#00                 boot-up",
        "            0.500000  probe       085#0010036669656C64   EMCY 1000h register 03h",
        "        probe: node 5, PRE-OPERATIONAL",
        "          faults: error(code=4096, register=3)",
    ]


def test_the_scene_is_that_of_the_moment_it_went_wrong(story):
    verdict = play(
        story(
            """\
            - {at: 0, write: {Producer heartbeat: 10}}
            - {at: 1, expect: {heartbeat: stopped, within: 1}}
            - {at: 3, nmt: stop}
            """
        )
    )
    *frames, state, faults = verdict.outcomes[0].scene.splitlines()
    times = [float(line.split()[0]) for line in frames]
    before, mark, after = times[:SHOWN], times[SHOWN], times[SHOWN + 1 :]
    assert (before[-1], mark) == (2.0, 2.0)
    assert after == [2.01, 2.02, 2.03, 2.04, 2.05]
    assert frames[SHOWN].endswith("---- here")
    assert (state, faults) == ("probe: node 5, PRE-OPERATIONAL", "  faults: none")


def test_what_is_left_out_is_better_than_a_failure_and_worse_than_nothing_wrong():
    assert list(Kind) == [Kind.PASS, Kind.SKIP, Kind.FAIL, Kind.ERROR]
    verdict = Verdict("story.yaml", (Outcome(Kind.SKIP, 0.0, 1, "what", "only simulated"),))
    assert (verdict.kind, verdict.ok) == (Kind.SKIP, True)
