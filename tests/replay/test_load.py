import pytest
from probe import Probe

from canopen_twins.scenario.scenario import At


def test_a_file_says_who_takes_part_and_what_happens_when(loaded):
    scenario = loaded(
        """\
        version: 1
        name: A story
        note: Of a probe.
        node: {device: probe, node_id: 7}
        steps:
          - at: 0.5
            note: Why not.
            nmt: start
          - {at: 1, expect: {emcy: none, within: 2.5}}
        """
    )
    assert (scenario.name, scenario.note) == ("A story", "Of a probe.")
    assert {name: spec.device for name, spec in scenario.nodes.items()} == {"probe": Probe}
    assert scenario.nodes["probe"].create().node_id == 7
    steps = [(step.moment, step.node, step.line, step.note) for step in scenario.steps]
    assert steps == [(At(0.5), "probe", 6, "Why not."), (At(1.0), "probe", 9, "")]


def test_a_scenario_without_a_name_has_that_of_its_file(loaded):
    scenario = loaded("{version: 1, node: {device: probe}, steps: []}")
    assert (scenario.name, scenario.note, scenario.duration) == ("story", "", None)


def test_settings_are_delivered_with_the_device(loaded):
    scenario = loaded(
        """\
        version: 1
        node: {device: topcon, settings: {load: resistor 4, serial: 0x10, ovp_when_off: false}}
        steps: []
        """
    )
    settings = scenario.nodes["topcon"].create().settings
    assert (settings.load, settings.serial, settings.ovp_when_off) == ("resistor 4", 16, False)


def test_everything_that_is_wrong_is_told_at_once_in_the_order_of_the_file(problems):
    text = """\
        version: 2
        node: {device: probe, node_id: 5, id: 4}
        nots: typo
        steps:
          - {at: -1, nmt: start}
          - {at: 0, nmt: sart}
          - {at: 0, write: {Byte: 256, Wrod: 1}}
        """
    assert problems(text) == [
        "1:10: version 2 is unknown; this program reads 1",
        "2:35: unknown key 'id': there is device, node_id, settings, timing",
        "3:1: unknown key 'nots': did you mean 'note'?",
        "5:10: -1 s is not in 0..86400 s",
        "6:18: unknown NMT command 'sart': did you mean 'start'?",
        "7:27: 256 is not in 0..255; if that is the point, put the abort code beside",
        "7:32: unknown object 'Wrod': did you mean 'Word'?",
    ]


def test_without_a_device_keys_and_times_are_checked_all_the_same(problems):
    text = """\
        version: 1
        node: {device: prob}
        steps:
          - {at: 1, write: {whatever: 1}}
          - {at: 0, wirte: {whatever: 1}}
        """
    unknown_device, *others = problems(text)
    assert unknown_device.startswith("2:16: unknown device 'prob'")
    assert others == [
        "5:10: 0 s is before 1 s, of a step above",
        "5:13: unknown key 'wirte': did you mean 'write'?",
    ]


@pytest.mark.parametrize(
    ("node", "problem"),
    [
        ("probe", "2:7: a key with a value is wanted here, such as {key: value}"),
        ("{node_id: 5}", "2:7: 'device' is missing"),
        ("{device: [probe]}", "2:16: one value is wanted here, not several"),
        ("{device: topkon}", "2:16: unknown device 'topkon': did you mean 'topcon'?"),
        ("{device: probe, node_id: 128}", "2:32: node id 128 is not in 1..127"),
        ("{device: probe, node_id: 010}", "2:32: 010 may be taken for different numbers"),
        ("{device: topcon, settings: []}", "2:34: a key with a value is wanted here"),
        ("{device: topcon, settings: {laod: open}}", "2:35: unknown setting 'laod'"),
        ("{device: topcon, settings: {load: opne}}", "2:41: setting 'load': "),
        ("{device: topcon, settings: {units: two}}", "2:42: setting 'units' wants a whole"),
        ("{device: topcon, settings: {firmware: 4.20}}", "2:45: setting 'firmware' wants a text"),
        ("{device: topcon, settings: {node_id: 5}}", "2:35: the node id stands beside the"),
        ("{device: topcon, settings: {load: [a]}}", "2:41: one value is wanted here"),
    ],
)
def test_a_node_that_cannot_take_part_is_pointed_at(problems, node, problem):
    (found,) = problems(f"version: 1\nnode: {node}\nsteps: []\n")
    assert found.startswith(problem)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "1:1: an empty file; the first line is version: 1"),
        ("# nothing\n", "1:1: an empty file; the first line is version: 1"),
        ("- 1\n", "1:1: a key with a value is wanted here, such as {key: value}"),
        ("{node: {device: probe}, steps: []}", "1:1: 'version' is missing"),
        ("{version: 1, steps: []}", "1:1: nothing says who takes part: a scenario"),
        ("{version: 1, node: {device: probe}}", "1:1: 'steps' is missing"),
        (
            "{version: 1, node: {device: probe}, always: []}",
            "1:45: 'always' stands beside 'steps' or 'duration' only",
        ),
        ("{version: 1.5, node: {device: probe}, steps: []}", "1:11: 1.5 is no whole number"),
        (
            "{version: '1', node: {device: probe}, steps: []}",
            "1:11: '1' stands in quotes and is a text",
        ),
        ("{version: 1, node: {device: probe}, steps: 5}", "1:44: a list is wanted here"),
        ("{version: 1, node: {device: probe}, steps: [5]}", "1:45: a key with a value is"),
        (
            "{version: 1, nodes: {a: {device: probe}}, node: {device: topcon}, steps: []}",
            "1:1: node and nodes at once: a scenario has one of node, nodes",
        ),
        ("{version: 1, name: [], node: {device: probe}, steps: []}", "1:20: one value is"),
    ],
)
def test_a_file_that_is_no_scenario_is_pointed_at(problems, text, problem):
    (found,) = problems(text)
    assert found.startswith(problem)


def test_a_device_is_made_once_to_look_at_its_settings_and_to_rehearse(loaded, monkeypatch):
    made = []

    def make_model(device):
        made.append(device)

    monkeypatch.setattr(Probe, "make_model", make_model)
    loaded("{version: 1, node: {device: probe}, steps: [{at: 1, nmt: start}]}")
    assert len(made) == 1
