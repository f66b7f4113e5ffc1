from io import StringIO

from canopen_twins.scenario import play

STORY = """\
- {at: 0.5, write: {Producer heartbeat: 100}}
- {at: 0.5, expect: {heartbeat: pre-operational, within: 0.2}}
- {at: 0.75, inject: {error: {code: 0x1000}}}
- {at: 0.75, expect: {emcy: {code: 0x1001}, within: 0.1}}
"""


def test_the_trace_is_what_candump_would_have_logged(story):
    trace = StringIO()
    play(story(STORY), trace)
    assert trace.getvalue() == (
        "(0000000000.000000) can0 705#00\n"
        "(0000000000.500000) can0 605#2B17100064000000\n"
        "(0000000000.500000) can0 585#6017100000000000\n"
        "(0000000000.600000) can0 705#7F\n"
        "(0000000000.700000) can0 705#7F\n"
        "(0000000000.750000) can0 085#0010016669656C64\n"
        "(0000000000.800000) can0 705#7F\n"
    )


def test_the_same_scenario_played_again_gives_the_same_trace_and_verdict(story):
    scenario = story(STORY)
    first, second = StringIO(), StringIO()
    assert play(scenario, first) == play(scenario, second)
    assert first.getvalue() == second.getvalue()


LOADED = """\
version: 1
node: {device: topcon, settings: {load: battery 350 0.1, noise: 3, power_on_current: 4000}}
steps:
  - {at: 0, nmt: start}
  - {at: 0, write: {Producer Heartbeat Time: 7, Voltage reference: 3700, 0x2014: 1}}
  - {at: 0.0505, send: 181#R}
"""
LOOKS = "".join(
    f"  - {{at: {at / 1000}, expect: {{value: {{Actual voltage: 9}}, within: {at / 300}}}}}\n"
    for at in range(51, 300, 9)
)
LATER = "  - {at: 3, send: 181#R}\n"


def test_a_look_at_values_leaves_no_trace(loaded):
    left_alone, looked_at = StringIO(), StringIO()
    assert play(loaded(LOADED + LATER), left_alone).ok
    assert not play(loaded(LOADED + LOOKS + LATER), looked_at).ok
    assert "(0000000003.000000) can0 181#" in left_alone.getvalue()
    assert looked_at.getvalue().startswith(left_alone.getvalue())


def test_a_scenario_without_steps_boots_and_that_is_all(loaded):
    trace = StringIO()
    assert play(loaded("{version: 1, node: {device: probe}, steps: []}"), trace).ok
    assert trace.getvalue() == "(0000000000.000000) can0 705#00\n"
