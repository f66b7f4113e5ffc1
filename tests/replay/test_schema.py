import json
import re
from contextlib import redirect_stdout
from functools import cache
from io import StringIO
from pathlib import Path

import pytest
import yaml
from jsonschema import Draft202012Validator

from canopen_twins.cli import main
from canopen_twins.files.yaml_nodes import compose, scalar
from canopen_twins.scenario import ScenarioError

ROOT = Path(__file__).parents[2]
SHIPPED = sorted(ROOT.glob("scenarios/*.yaml"))
PAGES = {"scenario": "scenarios.md", "bench": "bench-files.md"}


@pytest.fixture(scope="module")
def schema():
    """What the command prints."""

    @cache
    def schema(kind="scenario"):
        with redirect_stdout(StringIO()) as out:
            assert main(["schema", kind]) == 0
        return json.loads(out.getvalue())

    return schema


@pytest.fixture(scope="module")
def objections(schema):
    """What a schema has against a text."""

    @cache
    def checks(kind):
        return Draft202012Validator(schema(kind))

    def objections(text, kind="scenario"):
        return [error.message for error in checks(kind).iter_errors(plain(compose(text)))]

    return objections


def plain(node):
    """A file as editors see it, by YAML 1.2: on and off are words."""
    if isinstance(node, yaml.MappingNode):
        return {key.value: plain(value) for key, value in node.value}
    if isinstance(node, yaml.SequenceNode):
        return [plain(value) for value in node.value]
    return scalar(node)


def tables(schema):
    """The tables of a schema: the whole, and those it refers to."""
    return [schema, *schema["$defs"].values()]


@pytest.mark.parametrize("kind", PAGES)
def test_it_is_a_schema_that_says_what_every_key_means(schema, kind):
    Draft202012Validator.check_schema(schema(kind))
    for table in tables(schema(kind)):
        assert table["title"]
        assert table["description"]
        mute = [key for key, told in table["properties"].items() if not told.get("description")]
        assert mute == []


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_it_has_nothing_against_what_is_shipped(objections, path):
    assert objections(path.read_text("utf-8")) == []


@pytest.mark.parametrize("kind", PAGES)
def test_it_has_nothing_against_what_the_docs_show(objections, kind):
    page = (ROOT / "docs" / "reference" / PAGES[kind]).read_text("utf-8")
    shown = re.findall(r"```yaml.*?\n(.*?)```", page, re.DOTALL)
    assert shown
    assert [objections(text, kind) for text in shown] == [[]] * len(shown)


@pytest.mark.parametrize("kind", PAGES)
def test_the_docs_have_every_key(schema, kind):
    page = (ROOT / "docs" / "reference" / PAGES[kind]).read_text("utf-8")
    keys = {key for table in tables(schema(kind)) for key in table["properties"]}
    assert [key for key in sorted(keys) if not re.search(rf"`[^`\n]*\b{key}\b", page)] == []


HEAD = "version: 1\nnode: {device: probe}\n"
BROKEN = [
    "version: 2\nnode: {device: probe}\nsteps: []",
    "version: 1\nsteps: []",
    "version: 1\nnode: {device: probe}\nnodes: {a: {device: probe}}\nsteps: []",
    "version: 1\nnode: {node_id: 5}\nsteps: []",
    HEAD + "nots: typo\nsteps: []",
    HEAD + "seed: -1\nsteps: []",
    HEAD + "steps: {}",
    *(
        f"{HEAD}steps:\n- {{{step}}}"
        for step in (
            "nmt: start",
            "at: 1",
            "at: 1, after: 1, nmt: start",
            "at: 1, nmt: start, power: on",
            "at: -1, nmt: start",
            "at: soon, nmt: start",
            "at: 1, nmt: sart",
            "at: 1, power: true",
            "at: 1, send: 1080",
            "at: 1, every: 1, nmt: start",
            "at: 1, every: 0, times: 2, nmt: start",
            "at: 1, nmt: start, abort: 1",
            "at: 1, write: {Byte: 1}, abort: 0",
            "at: 1, write: {}",
            "at: 1, write: {Byte: [1]}",
            "at: 1, clear: all, for: 1",
            "at: 1, inject: {error: 5}",
            "at: 1, inject: error, for: 1, until: {emcy: any}",
            "when: {silence: true}, nmt: start",
            "when: {emcy: any, nth: 0}, nmt: start",
            "when: {heartbeat: any, from: master}, nmt: start",
            "at: 1, expect: {within: 1}",
            "at: 1, expect: {emcy: none}",
            "at: 1, expect: {emcy: {}, within: 1}",
            "at: 1, expect: {emcy: {code: 0x10000}, within: 1}",
            "at: 1, expect: {emcy: none, silence: true, within: 1}",
            "at: 1, expect: {silence: false, within: 1}",
            "at: 1, expect: {value: {Byte: {is: 1, max: 5}}}",
            "at: 1, expect: {value: {Byte: {}}}",
            "at: 1, expect: {never: {silence: true}}",
            "at: 1, expect: {never: {emcy: any, nmt: start}}",
        )
    ),
    HEAD + "steps: []\ncleanup:\n- {at: 1, nmt: start}",
]


@pytest.mark.parametrize("text", BROKEN)
def test_it_refuses_what_is_refused_when_it_is_read(objections, loaded, text):
    assert objections(text)
    with pytest.raises(ScenarioError):
        loaded(text)


@pytest.mark.parametrize(
    "nodes", ["{}", "[]", "{a: {}}", "{a: {device: probe, node_id: 128}}", "{a: 5}"]
)
def test_it_refuses_a_bench_of_nobody(objections, nodes):
    assert objections(f"version: 1\nnodes: {nodes}", "bench")
