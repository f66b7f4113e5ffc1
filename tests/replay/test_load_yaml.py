import re
from contextlib import suppress
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from canopen_twins.files.document import LARGEST_FILE
from canopen_twins.files.yaml_nodes import nodes, scalar
from canopen_twins.scenario import ScenarioError, load

from .conftest import HEAD

SHIPPED = sorted((Path(__file__).parents[2] / "scenarios").glob("*.yaml"))[::10]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("a: [1,\nb: 2", "2:5: while parsing a flow sequence, expected ',' or ']'"),
        ("a: 1\n  b: 2", "2:4: mapping values are not allowed here"),
        ("a:\n\tb: 1", "2:1: a tab: indent with spaces"),
        ("a: 1\n--- \nb: 2", "2:1: expected a single document in the stream"),
        ("a: 1\nb: \x07", "2:4: special characters are not allowed"),
        ("a: *b", "1:4: there are no anchors and aliases here: write it out"),
        ("a: &b 1\nc: *b", "1:4: there are no anchors and aliases here: write it out"),
        ("a: !!python/name:os.system x", "1:4: there are no tags here: leave"),
        ("a: !!str 5", "1:4: there are no tags here: leave 'tag:yaml.org,2002:str' out"),
        ("[" * 1500, "1:1: nested too deeply; five levels are enough"),
    ],
)
def test_what_is_no_yaml_of_ours_is_pointed_at(problems, text, problem):
    (found,) = problems(text)
    assert found.startswith(problem)


def test_a_key_that_stands_twice_is_refused_wherever_it_is(problems):
    text = """\
        version: 1
        node: {device: topcon, settings: {load: open, load: short}}
        version: 1
        steps:
          - at: 0
            write:
              Voltage reference: 1
              Voltage reference: 2
        """
    assert problems(text) == [
        "2:47: 'load' stands here twice, first in line 2; leave one of them out",
        "3:1: 'version' stands here twice, first in line 1; leave one of them out",
        "8:7: 'Voltage reference' stands here twice, first in line 7; leave one of them out",
    ]


@pytest.mark.parametrize(("word", "powered"), [("on", True), ("off", False)])
def test_on_and_off_are_words(played, word, powered):
    step = f"- {{at: 1, power: {word}}}\n- {{at: 1, expect: {{value: {{Read only: 9}}}}}}\n"
    _, (outcome,) = played(step)
    assert outcome.startswith("PASS" if powered else "FAIL")


@pytest.mark.parametrize(
    ("text", "number"), [("16", 16), ("0x10", 16), ("+16", 16), ("0", 0), ("255", 255)]
)
def test_numbers_are_what_they_look_like(played, text, number):
    frames, _ = played(f"- {{at: 1, write: {{Byte: {text}}}}}\n")
    assert frames[1] == f"1 605#2F002000{number:02X}000000"


def test_a_file_with_a_byte_order_mark_is_read(tmp_path):
    path = tmp_path / "story.yaml"
    path.write_bytes(b"\xef\xbb\xbf{version: 1, node: {device: topcon}, steps: []}")
    assert load(path).name == "story"


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"\xff\xfe", "no UTF-8 text"),
        (b"#" * (LARGEST_FILE + 1), f"larger than {LARGEST_FILE} bytes"),
    ],
)
def test_what_is_no_text_of_a_reasonable_size_is_refused(tmp_path, content, problem):
    path = tmp_path / "story.yaml"
    path.write_bytes(content)
    with pytest.raises(ScenarioError) as refusal:
        load(path)
    assert str(refusal.value) == f"{path}: {problem}"


def test_a_file_of_many_steps_is_read(story):
    assert len(story("- {at: 1, nmt: start}\n" * 3000).steps) == 3000


def test_what_cannot_be_opened_is_told_in_one_line(tmp_path):
    for path in (tmp_path / "none.yaml", tmp_path):
        with pytest.raises(ScenarioError) as refusal:
            load(path)
        assert str(refusal.value).startswith(f"{path}: ")
        assert len(refusal.value.lines) == 1


def test_a_large_mistake_is_many_lines_and_one_error(problems):
    found = problems(HEAD + "  - {at: 1, do: it}\n" * 500)
    assert len(found) == 500


ROOT = Path(__file__).parents[2]
DOCS = (ROOT / "docs" / "reference" / "scenarios.md").read_text("utf-8")
FILES = [
    (ROOT / "scenarios" / "topcon_interlock.yaml").read_text("utf-8"),
    *re.findall(r"```yaml file=.*?\n(.*?)```", DOCS, re.DOTALL),
]
PIECES = ["{", "}", "[", "]", ": ", "- ", "\n", "'", "#", "0x", "-", "null", "off", "expect", "set"]
PIECES += [
    "any",
    "none",
    "never: ",
    "from: master, ",
    "before: ",
    "node: ",
    "5",
    "{}",
    "[]",
    "until",
]


@settings(max_examples=200, deadline=None)
@given(st.sampled_from(FILES), st.data())
def test_whatever_a_slip_makes_of_a_file_is_told_in_lines_with_their_places(
    tmp_path_factory, file, data
):
    at = data.draw(st.integers(0, len(file)))
    rest = file[at + data.draw(st.integers(0, 12)) :]
    piece = data.draw(st.sampled_from(PIECES) | st.text())
    path = tmp_path_factory.mktemp("slip") / "story.yaml"
    path.write_bytes((file[:at] + piece + rest).encode("utf-8", "ignore"))
    with suppress(ScenarioError):
        load(path)


def everything(node):
    """What a node says, and where."""
    place = (node.start_mark.line, node.start_mark.column)
    if isinstance(node, yaml.ScalarNode):
        return place, scalar(node)
    if isinstance(node, yaml.SequenceNode):
        return place, [everything(each) for each in node.value]
    return place, [(everything(key), everything(value)) for key, value in node.value]


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_scenario_is_the_same_with_and_without_libyaml(path):
    text = path.read_text("utf-8")
    assert everything(nodes(text)) == everything(nodes(text, yaml.SafeLoader))
