import pytest

from canopen_twins.scenario.scenario import After, At
from canopen_twins.scenario.schema import MOST_NODES, MOST_STEPS


def test_a_file_has_everything_that_is_about_the_whole_run(loaded):
    scenario = loaded(
        """\
        version: 1
        covers: [T-193, C-12]
        seed: 7
        duration: 20
        bit_rate: 125000
        node: {device: probe}
        steps: []
        cleanup:
          - {clear: all}
          - {after: 0.5, power: off}
        """
    )
    assert scenario.covers == ("T-193", "C-12")
    assert (scenario.seed, scenario.duration, scenario.bit_rate) == (7, 20.0, 125000)
    assert [step.moment for step in scenario.cleanup] == [After(0), After(0.5)]


def test_what_a_file_does_not_say_is_as_it_was(loaded):
    scenario = loaded("{version: 1, node: {device: probe}, steps: []}")
    assert (scenario.covers, scenario.seed) == ((), 1)
    assert (scenario.duration, scenario.bit_rate, scenario.cleanup) == (None, None, ())


def test_each_step_is_about_its_node_with_the_names_of_its_device(loaded):
    scenario = loaded(
        """\
        version: 1
        nodes:
          supply: {device: topcon, node_id: 5, settings: {load: resistor 4}}
          other: {device: probe, node_id: 6}
        steps:
          - {at: 0, node: supply, write: {Run command: 1}, note: Not of the probe.}
          - {at: 0, node: other, write: {Byte: 1}}
          - {when: {value: {Byte: 1}, node: other}, node: supply, set: {load: open}}
        """
    )
    assert {name: spec.create().node_id for name, spec in scenario.nodes.items()} == {
        "supply": 5,
        "other": 6,
    }
    assert [step.node for step in scenario.steps] == ["supply", "other", "supply"]
    assert [step.moment for step in scenario.steps[:2]] == [At(0), At(0)]
    assert scenario.steps[2].moment.node == "other"


def test_a_single_node_may_be_named_by_its_device(loaded):
    text = "{version: 1, node: {device: probe}, steps: [{at: 0, node: probe, nmt: start}]}"
    assert loaded(text).steps[0].node == "probe"


SEEDS = """\
version: 1
{}
node: {{device: {}}}
steps:
  - {{at: 0, inject: {{frame_lost: {{frame: 080#, probability: 0.5}}}}}}
  - {{at: 0, inject: {{frame_lost: {{frame: 080#, seed: 3}}}}}}
"""


def test_a_seed_is_that_of_every_fault_and_device_that_is_given_none(loaded):
    first, second = (step.action.faults for step in loaded(SEEDS.format("seed: 9", "probe")).steps)
    assert (first["frame_lost"]["seed"], second["frame_lost"]["seed"]) == (9, 3)
    (spec,) = loaded(SEEDS.format("seed: 9", "topcon")).nodes.values()
    assert spec.create().settings.seed == 9
    (spec,) = loaded(SEEDS.format("seed: 9", "topcon, settings: {seed: 4}")).nodes.values()
    assert spec.create().settings.seed == 4


def test_without_a_seed_each_has_its_own(loaded):
    scenario = loaded(SEEDS.format("note: none", "topcon"))
    assert "seed" not in scenario.steps[0].action.faults["frame_lost"]
    assert "seed" not in scenario.nodes["topcon"].settings


@pytest.mark.parametrize(
    ("line", "wrong"),
    [
        ("seed: -1", "2:7: -1 is not in 0..4294967295"),
        ("seed: 0x100000000", "2:7: 0x100000000 is not in 0..4294967295"),
        ("duration: 100000", "2:11: 100000 s is not in 0..86400 s"),
        ("bit_rate: 5000", "2:11: 5000 is not in 10000..1000000"),
        ("covers: T-193", "2:9: a list is wanted here, each value after a dash"),
        ("covers: [[T-193]]", "2:10: one value is wanted here, not several"),
        ("cleanup: {}", "2:10: a list is wanted here, each value after a dash"),
        ("cleanup: [{at: 1, nmt: start}]", "2:12: unknown key 'at'"),
        ("cleanup: [{when: {emcy: any}, nmt: start}]", "2:12: unknown key 'when'"),
        ("cleanup: [{nmt: go}]", "2:17: unknown NMT command 'go': there is"),
    ],
)
def test_what_a_file_cannot_say_is_pointed_at(problems, line, wrong):
    (found,) = problems(f"version: 1\n{line}\nnode: {{device: probe}}\nsteps: []\n")
    assert found.startswith(wrong)


def test_names_are_looked_up_where_they_can_be(problems):
    text = """\
        version: 1
        nodes:
          left: {device: probe, node_id: 5}
          right: {device: prob, node_id: 6}
          third: {node_id: 7}
          fourth: {device: probe, node_id: 5}
        steps:
          - {at: 1, node: left, write: {Byt: 1}, note: [a]}
          - {at: 1, node: right, write: {Whatever: 1}}
          - {at: 1, node: third, nmt: sart}
          - {at: 1, node: fifth, nmt: start}
          - 5
          - {when: {emcy: {cod: 1}}, node: left, inject: eror}
        cleanup:
          - {node: left, clear: eror}
        """
    assert problems(text) == [
        "4:19: unknown device 'prob': there is charger, gateway, topcon;"
        " a path to an EDS file is one, too",
        "5:10: 'device' is missing",
        "6:3: two nodes with node id 5 on one bus",
        "8:33: unknown object 'Byt': did you mean 'Byte'?",
        "8:48: one value is wanted here, not several",
        "10:31: unknown NMT command 'sart': did you mean 'start'?",
        "11:19: unknown node 'fifth': there is fourth, left, right, third",
        "12:5: a key with a value is wanted here, such as {key: value}",
        "13:20: unknown key 'cod': did you mean 'code'?",
        "13:50: unknown fault 'eror': did you mean 'error'?",
        "15:25: unknown fault 'eror': did you mean 'error'?",
    ]


def test_there_is_an_end_to_steps_and_nodes(problems):
    steps = "- 1\n" * (MOST_STEPS + 1)  # which are none, but read in no time
    first, *_ = problems(f"version: 1\nnode: {{device: probe}}\nsteps:\n{steps}")
    assert first == f"4:1: more than {MOST_STEPS} of them"
    nodes = "".join(f"  n{n}: {{device: probe}}\n" for n in range(MOST_NODES + 1))
    (found,) = problems(f"version: 1\nnodes:\n{nodes}steps: []\n")
    assert found == f"3:3: more than {MOST_NODES} of them"
