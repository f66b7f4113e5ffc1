"""What goes wrong beside the steps of a file, and whether the master is back when it has healed."""

import shutil
from pathlib import Path

import pytest

from canopen_twins import play
from canopen_twins.errors import UserError
from canopen_twins.scenario import load

HEAD = """\
version: 1
node: {device: topcon, node_id: 5, settings: {load: resistor 4}}
"""
SWITCH_ON = """\
steps:
  - {at: 0.1, write: {Voltage reference: 2000, Current reference: 4000, Run command: 1}}
"""


OBJECTS = """\
version: 1
node: {device: battery.eds, node_id: 5}
duration: 2
disturbances:
  - {at: 1, set: {Current: -5, Undervoltage limit: 47000}}
recovers: {within: 1, when: {value: {Current: 0, Undervoltage limit: 46000}}}
"""
EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"


@pytest.fixture
def story(tmp_path):
    def story(text, steps=SWITCH_ON):
        path = tmp_path / "story.yaml"
        path.write_text(HEAD + steps + text)
        return load(path)

    return story


@pytest.fixture
def judged(story):
    """The outcomes of a file: what, seen, kind."""

    def judged(text, **steps):
        return [(o.what, o.seen, str(o.kind)) for o in play(story(text, **steps)).outcomes]

    return judged


def told(scenario):
    """What the player tells of injections: seconds, kind and fault."""
    found = []

    def attach(segment, player):
        def hear(event):
            if event.kind in ("inject", "clear"):
                found.append((round(event.time, 3), event.kind, event.fields["fault"]))

        player.listeners.append(hear)

    play(scenario, observers=[attach])
    return found


def test_disturbances_come_each_at_its_own_moment_in_any_order(story):
    scenario = story("""\
duration: 4
disturbances:
  - {at: 3, inject: sdo_silence}
  - {when: {write: {Run command: 1}}, inject: heartbeat_stopped, for: 2}
  - {when: {emcy: any}, inject: frame_lost}
  - {at: 0.5, inject: interlock_open, until: {emcy: any}}
""")
    assert told(scenario) == [
        (0.1, "inject", "heartbeat_stopped"),
        (0.5, "inject", "interlock_open"),
        (0.501, "inject", "frame_lost"),
        (0.501, "clear", "interlock_open"),
        (2.1, "clear", "heartbeat_stopped"),
        (3.0, "inject", "sdo_silence"),
    ]


def test_one_that_never_comes_is_nothing_to_judge(judged):
    text = "duration: 1\ndisturbances:\n  - {when: {emcy: any}, inject: sdo_silence}\n"
    assert judged(text) == []


def test_one_that_the_device_refuses_is_an_error(judged):
    text = "duration: 1\ndisturbances:\n  - {at: 0.5, set: {load: resistor 0}}\n"
    with pytest.raises(UserError):
        judged(text)


RECOVERS = """\
duration: 2
recovers: {within: 3, when: {value: {Voltage reference: 2000}}}
disturbances:
"""


@pytest.mark.parametrize(
    ("disturbance", "kind"),
    [
        ("{at: 1, power: off}", "FAIL"),  # nobody sets it again
        ("{at: 1, inject: sdo_silence}", "PASS"),
        ("{at: 3, power: off}", "PASS"),  # by then nothing goes wrong any more
    ],
)
def test_the_master_has_to_be_back_when_all_has_healed(judged, disturbance, kind):
    *_, (what, _, found) = judged(f"{RECOVERS}  - {disturbance}\n")
    assert (what, found) == ("back within 3 s: Voltage reference 2000", kind)


def test_who_is_not_back_in_time_is_told_when_the_time_is_over(story):
    verdict = play(story(f"{RECOVERS}  - {{at: 1, power: off}}\n"))
    (outcome,) = verdict.outcomes
    assert (outcome.time, outcome.line) == (pytest.approx(5, abs=1e-3), 6)
    assert verdict.seconds == pytest.approx(5, abs=1e-3)


def test_everything_heals(story):
    scenario = story(f"""\
{RECOVERS}  - {{at: 0.5, inject: sdo_silence}}
  - {{at: 0.5, set: {{load: resistor 8}}}}
""")
    loads = []

    def attach(segment, player):
        (node,) = segment.nodes
        for time in (0.4, 1, 2.1):
            segment.clock.at(
                time, lambda: loads.append((node.device.settings.load, dict(node.faults.active)))
            )

    play(scenario, observers=[attach])
    (before, _), (meanwhile, active), (after, healed) = loads
    assert [*active] == ["sdo_silence"]
    assert (before, meanwhile, after, healed) == ("resistor 4", "resistor 8", "resistor 4", {})


def test_objects_that_were_set_heal_too(tmp_path):
    shutil.copy(EXAMPLES / "battery" / "battery.eds", tmp_path)
    path = tmp_path / "story.yaml"
    path.write_text(OBJECTS)
    (back,) = play(load(path)).outcomes
    assert (back.seen, str(back.kind)) == ("Current is 0, Undervoltage limit is 46000", "PASS")


def test_an_object_that_was_beyond_its_limits_is_so_again(tmp_path):
    eds = (EXAMPLES / "battery" / "battery.eds").read_text()
    limited = "DefaultValue=46000\nLowLimit=40000\n"
    assert limited in eds
    text = eds.replace(limited, limited.replace("46000", "39999"))
    (tmp_path / "battery.eds").write_text(text)
    path = tmp_path / "story.yaml"
    path.write_text(OBJECTS.replace("46000", "39999"))
    (back,) = play(load(path)).outcomes
    assert (back.seen, str(back.kind)) == ("Current is 0, Undervoltage limit is 39999", "PASS")


def test_what_is_seen_counts_from_then_on_and_after_the_boot_time(judged):
    steps = """\
timing: worst
steps:
  - {at: 0.1, write: {Run command: 1}}
  - {when: {state: pre-operational}, nmt: start}
"""
    text = """\
duration: 5
recovers: {within: 1, when: {state: operational}}
disturbances:
  - {at: 4, inject: {power_cycle: {seconds: 30}}}
"""
    *_, (what, seen, kind) = judged(text, steps=steps)
    assert (what, seen, kind) == ("back within 1 s: state operational", "operational", "PASS")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("disturbances:\n  - {inject: sdo_silence}\n", "nothing says when"),
        ("disturbances:\n  - {at: 1}\n", "nothing to go wrong"),
        ("disturbances:\n  - {at: 1, write: {Run command: 1}}\n", "unknown key 'write'"),
        ("disturbances:\n  - {at: 1, power: off, for: 2}\n", "'for' stands beside 'inject'"),
        (
            "recovers: {within: 1, when: {state: operational}}\n",
            "'recovers' stands beside 'duration'",
        ),
        (
            "duration: 1\nrecovers: {within: 1, when: {state: operational, nth: 2}}\n",
            "unknown key 'nth'",
        ),
    ],
)
def test_what_is_no_disturbance_is_told_with_its_place(story, text, said):
    with pytest.raises(UserError) as refusal:
        story(text)
    assert said in str(refusal.value)
    assert "story.yaml:" in str(refusal.value)
