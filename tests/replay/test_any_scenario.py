"""Whatever a scenario has in it, it ends, twice the same, and says something of every step."""

from collections import Counter
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from probe import Probe

from canopen_twins import devices
from canopen_twins.scenario import Kind, load, play

NODES = {"left": {"device": "probe", "node_id": 5}, "right": {"device": "probe", "node_id": 6}}
nodes = st.sampled_from(sorted(NODES))
seconds = st.sampled_from([0, 0.000001, 0.02, 0.1, 0.25, 1])
values = st.one_of(st.sampled_from([0, 1, 2, "any"]), st.just({"min": 1}))
commands = st.sampled_from(
    ["start", "stop", "pre-operational", "reset-node", "reset-communication"]
)
objects = st.sampled_from(["Byte", "Word", "Level", "0x2002"])
readable = st.sampled_from(["Byte", "Level", "0x1000"])
frames = st.sampled_from(["080#", "185#*", "705#xx", "585#*", "2xx#*", "605#*"])
states = st.sampled_from(["operational", "pre-operational", "stopped", "initialising"])
heartbeats = st.sampled_from(["operational", "any"])
emcys = st.one_of(st.just("any"), st.just({"code": 0x1000}), st.just({"register": 1}))


def one(key, of):
    return of.map(lambda value: {key: value})


signs = st.one_of(
    one("emcy", emcys),
    one("frame", frames),
    frames.map(lambda frame: {"frame": frame, "from": "master"}),
    one("heartbeat", heartbeats),
    one("value", st.dictionaries(readable, values, min_size=1, max_size=2)),
    one("state", states),
    one("write", st.dictionaries(objects, values, min_size=1, max_size=2)),
    one("nmt", commands),
)
conditions = st.builds(
    lambda sign, nth, node: {**sign, "nth": nth, "node": node}, signs, st.integers(1, 3), nodes
)
windows = st.one_of(
    one("within", seconds),
    one("before", conditions),
    st.builds(lambda within, before: {"within": within, "before": before}, seconds, conditions),
)
expected = st.one_of(
    signs,
    one("never", signs),
    st.sampled_from([{"emcy": "none"}, {"heartbeat": "none"}, {"silence": True}]),
    st.just({"silence": True, "from": "master"}),
)
faults = st.sampled_from(
    [
        {"error": {"code": 0x1000}},
        {"error": {"code": 0x2000}},
        "heartbeat_stopped",
        "boot_up_lost",
        {"heartbeat_late": {}, "sdo_silence": {}},
        {"frame_lost": {"frame": "5xx#*", "probability": 0.5}},
    ]
)
deeds = st.one_of(
    one("expect", st.builds(lambda sign, window: {**sign, **window}, expected, windows)),
    one("expect", st.builds(lambda sign, window: {**sign, **window}, expected, windows)),
    one("nmt", commands),
    one("power", st.sampled_from(["on", "off"])),
    one("send", st.sampled_from(["080#", "000#8200", "205#01.02.03", "605#4000100000000000"])),
    one(
        "write", st.dictionaries(st.sampled_from(["Byte", "Level"]), st.integers(0, 2), min_size=1)
    ),
    one("read", st.dictionaries(readable, values, min_size=1)),
    st.builds(
        lambda verb, code: {verb: {"0x2002": 1}, "abort": code, "timeout": 0.3},
        st.sampled_from(["write", "read"]),
        st.sampled_from(["none", 0x08000021, 0x06010000]),
    ),
    one("write", st.just({"Producer heartbeat": 50})),
    one("inject", faults),
    st.builds(lambda fault, lasts: {"inject": fault, "for": lasts or 1}, faults, seconds),
    st.builds(lambda fault, until: {"inject": fault, "until": until}, faults, conditions),
    one("clear", st.just("all")),
)
moments = st.one_of(
    one("at", seconds), one("after", seconds), one("after", seconds), one("when", conditions)
)
repeated = st.one_of(
    st.just({}),
    st.just({}),
    st.builds(lambda every: {"every": every or 0.5, "times": 3}, seconds),
)
steps = st.builds(
    lambda moment, deed, again, node: {**moment, **deed, **again, "node": node},
    moments,
    deeds,
    repeated,
    nodes,
)
whole = st.fixed_dictionaries(
    {
        "version": st.just(1),
        "nodes": st.just(NODES),
        "seed": st.integers(0, 9),
        "steps": st.lists(steps, min_size=1, max_size=7),
        "cleanup": st.just([{"clear": "all", "node": name} for name in NODES]),
    },
    optional={"bit_rate": st.just(125000), "duration": st.sampled_from([0, 0.5, 3])},
)


def find(name):
    return Probe if name == "probe" else devices.find(name)


def in_order(story):
    """The same steps as a file has them: times ascend, and what is judged at a moment is last."""
    latest = 0.0
    for number, step in enumerate(story["steps"]):
        if "at" in step:
            latest = step["at"] = max(step["at"], latest)
        before = story["steps"][number - 1] if number else {}
        if "expect" in before and "expect" not in step:
            step.pop("at", None)
            if "when" not in step:
                step["after"] = step.get("after") or 0.01
    return story


def written(story) -> str:
    """As people write it: nothing is referred to, all is there."""
    dumper = type("Plain", (yaml.SafeDumper,), {"ignore_aliases": lambda self, data: True})
    return yaml.dump(story, Dumper=dumper, sort_keys=False)


def lived(scenario):
    """The trace, the verdict, and how often each line was carried out; no fault has stayed."""
    trace, nodes, lines = StringIO(), [], []

    def observe(segment, player):
        nodes.extend(segment.nodes)
        player.listeners.append(lines.append)

    verdict = play(scenario, trace, [observe])
    assert [name for node in nodes for name in node.faults.active] == []
    carried = Counter(event.fields["line"] for event in lines if event.kind == "step")
    return trace.getvalue(), verdict, carried


@settings(max_examples=60, deadline=None)
@given(whole.map(in_order))
def test_any_scenario_ends_twice_the_same_and_says_something_of_every_step(story):
    with TemporaryDirectory() as folder:
        path = Path(folder, "any.yaml")
        path.write_text(written(story))
        scenario = load(path, find)
    first = lived(scenario)
    assert first == lived(scenario)
    _, verdict, carried = first
    counts = Counter(outcome.line for outcome in verdict.outcomes)
    assert counts.keys() <= {step.line for step in (*scenario.steps, *scenario.cleanup)}
    assert all(carried[step.line] == 1 for step in scenario.cleanup)
    for told, step in zip(story["steps"], scenario.steps, strict=True):
        if verdict.kind is Kind.ERROR:
            assert carried[step.line] == step.times or counts[step.line]
        else:
            judged = not told.keys().isdisjoint(("expect", "read", "abort"))
            assert counts[step.line] == (step.times if judged else 0)
