"""An object may be called like anything: what its value waits for is told for what it is."""

from pathlib import Path
from textwrap import dedent

import pytest
from probe import Probe

from canopen_twins.scenario import load, play
from canopen_twins.slave.object import Object

BYTE = (0x2000, 0)  # in RPDO1
NAMES = ["Byte", "write protect", "EMCY pending", "heartbeat lost", "705# seen", "185# seen"]
NAMES += ["state operational", "NMT start", "frame count", "no frame", "no write access", "no"]


@pytest.fixture
def reasons(tmp_path):
    """What is told of a step that a probe does not come up to, whose byte has another name."""

    def reasons(name, does):
        eds, file = tmp_path / "named.eds", tmp_path / "story.yaml"
        given = Path(Probe.eds).read_text(encoding="ascii")
        eds.write_text(given.replace("=Byte\n", f"={name}\n"))

        class Named(Probe):
            pass

        Named.eds = str(eds)
        Named.objects = property(
            lambda self: {**Probe.objects.fget(self), BYTE: Object(obstacle=lambda _: "it is shut")}
        )
        file.write_text(
            dedent(f"""\
            version: 1
            node: {{device: named, node_id: 5}}
            steps:
              - {{at: 1, {does.format(name=name)}}}
            """)
        )
        (outcome,) = play(load(file, lambda _: Named)).outcomes
        told = outcome.scene.splitlines()
        return [line.removeprefix("  why: ") for line in told if line.startswith("  why: ")]

    return reasons


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    "does",
    [
        "expect: {{value: {{{name}: 7}}, within: 1}}",
        "expect: {{never: {{value: {{{name}: 0}}}}, within: 1}}",
        "read: {{{name}: 7}}",
    ],
)
def test_a_value_has_its_obstacle_as_a_reason(reasons, name, does):
    assert reasons(name, does) == [f"without effect now: it is shut, {name}"]


@pytest.mark.parametrize("name", NAMES)
def test_a_write_has_the_rpdo_as_a_reason(reasons, name):
    assert reasons(name, "expect: {{write: {{{name}: 7}}, within: 1}}") == [
        f"{name} is in RPDO1, 205h"
    ]
    assert reasons(name, "expect: {{never: {{write: {{{name}: 7}}}}, within: 1}}") == []
