"""A file judges a master alike: as steps of a file, in simulated time, and in real time."""

import json
from threading import Thread

import judged_master
import pytest

from canopen_twins.bench.simulated_time import simulated_time
from canopen_twins.cli import main
from canopen_twins.files.shipped import od_file
from canopen_twins.scenario import Verdict, load, play
from canopen_twins.scenario.play import ScenarioBench

pytestmark = pytest.mark.usefixtures("quick_to_disconnect")

JUDGE = """\
version: 1
node: {device: topcon, node_id: 5, settings: {load: resistor 4}}
steps:
  - at: 0
    expect: {never: {write: {Run command: any}}, before: {state: operational}}
  - when: {write: {Run command: 1}}
    expect: {value: {Voltage reference: 2000, Current reference: {min: 1}}}
  - after: 0.4
    inject: {error: {number: 0x23}}
  - when: {emcy: {code: 0x2300}}
    expect: {write: {Run command: 0}, within: 0.3}
  - after: 0
    expect: {never: {write: {Run command: 1}}, within: 0.35}
"""
START = """\
  - {at: 0.6, nmt: start}
  - {after: 0.1, write: {Voltage reference: 2000, Current reference: 4000, Run command: 1}}
"""
GIVES_UP = """\
  - {when: {emcy: {code: 0x2300}}, write: {Run command: 0}}
"""


def as_steps_of_the_file(file, gives_up, capsys):
    steps = START + (GIVES_UP if gives_up else "")
    file.write_text(JUDGE + steps)
    return [told for told in outcomes(play(load(file))) if told[1] <= JUDGE.count("\n")]


def in_simulated_time(file, gives_up, capsys):
    story = ScenarioBench(load(file))
    with simulated_time(story, judged_master), od_file("topcon.eds") as eds:
        bus = {"interface": "socketcan", "channel": "can0"}
        judged_master.charge(str(eds), 1.5, gives_up, **bus)
        story.finish()
    return outcomes(story.verdict)


def in_real_time(file, gives_up, capsys):
    bus = {"interface": "virtual", "channel": str(file)}
    with od_file("topcon.eds") as eds:
        master = Thread(
            target=judged_master.charge, args=(str(eds), 1.5, gives_up), kwargs=bus, daemon=True
        )
        master.start()
        code = main(["run", "-i", "virtual", "-c", str(file), "--scenario", str(file), "--json"])
        master.join()
    (told,) = json.loads(capsys.readouterr().out.splitlines()[-1])["scenarios"]
    assert code == (told["verdict"] != "PASS")
    return [
        (each["verdict"], each["line"], each["what"], each["seen"]) for each in told["outcomes"]
    ]


def outcomes(verdict: Verdict):
    return [(str(each.kind), each.line, each.what, each.seen) for each in verdict.outcomes]


@pytest.mark.parametrize("gives_up", [True, False])
@pytest.mark.parametrize("way", [as_steps_of_the_file, in_simulated_time, in_real_time])
def test_a_master_is_judged_alike_in_every_way(tmp_path, capsys, way, gives_up):
    file = tmp_path / "judge.yaml"
    file.write_text(JUDGE)
    found = way(file, gives_up, capsys)
    assert [told[:2] for told in found] == [
        ("PASS", 4),
        ("PASS", 6),
        ("PASS" if gives_up else "FAIL", 10),
        ("PASS", 12),
    ]
    assert found == as_steps_of_the_file(file, gives_up, capsys)
