"""How long a master waits for an answer is learnt, and answers are tried that come just then."""

from dataclasses import replace
from pathlib import Path

import pytest

from canopen_twins.bus.frame import Frame
from canopen_twins.device import Fault, Parameter
from canopen_twins.devices import topcon
from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.events import events_of
from canopen_twins.hunt.run import run
from canopen_twins.hunt.space import Space
from canopen_twins.hunt.waits import Wait, WaitRecorder

from .masters import CAREFUL, CONTRACT

VOLTAGE, COMMAND = (0x2010, 0), (0x2014, 0)


def waits(*frames):
    """Those of a trace of a node 5: milliseconds, and what is on the bus."""
    recorder = WaitRecorder()
    for milliseconds, text in frames:
        frame = Frame.parse(text)
        hear = recorder.ask if frame.can_id == 0x605 else recorder.answer
        hear("topcon", frame.data, milliseconds * 1000)
    return recorder.waits


LOST = [
    (0, "605#4010200000000000"),
    (10, "585#4B10200000000000"),
    (20, "605#4014200000000000"),  # and no answer
    (320, "605#8014200000000405"),
    (400, "605#4014200000000000"),
    (410, "585#4B14200001000000"),
    (411, "605#4011200000000000"),
    (421, "585#4B11200000000000"),
]


def test_what_comes_after_a_time_out_tells_how_late_an_answer_would_be_taken_for_another():
    assert waits(*LOST) == (
        Wait("topcon", COMMAND, "read", 1, 0.375, 0.01),
        Wait("topcon", COMMAND, "read", 2, 0.386, 0.01),
    )


def test_a_segment_that_does_not_come_is_of_its_object():
    assert waits(
        (0, "605#4008100000000000"),
        (10, "585#410810000D000000"),
        (11, "605#6000000000000000"),
        (311, "605#8008100000000405"),
        (400, "605#4008100000000000"),
    ) == (Wait("topcon", (0x1008, 0), "read", 1, 0.384, 0.01),)


def test_who_is_answered_shows_nothing():
    assert waits(*LOST[:2], (20, "605#4014200000000000"), (30, "585#4B14200001000000")) == ()


def test_who_asks_on_without_waiting_shows_nothing():
    assert waits(*LOST[:2], *((20 + n, "605#4010200000000000") for n in range(3))) == ()


@pytest.fixture
def space(tmp_path, monkeypatch):
    """What can go wrong with a master that waits 0.1 s for an answer."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_master.py").write_text(CAREFUL)
    (tmp_path / "contract.yaml").write_text(CONTRACT.replace("sdo_silence", "sdo_late"))
    contract = Contract(Path("contract.yaml"), "my_master:main")
    events, _ = events_of(contract, contract.scenario(Plan()))
    return Space(contract.scenario(Plan()), events)


FIRST = Wait("topcon", COMMAND, "read", 1, 0.6, 0.01)


def tried(space, *waits):
    """What is tried when these are learnt: when, and the parameters."""
    plans = [plan for source in space.learn(waits) for plan in source]
    given = [told["inject"]["sdo_late"] for plan in plans for told in plan.disturbances]
    return {(each.get("object"), each.get("access"), each["seconds"]) for each in given}


def test_the_shortest_is_tried_at_every_access_and_others_at_theirs(space):
    objects = ("Voltage reference", "Run command")
    every = {(name, access, 0.6) for name in objects for access in ("read", "write")}
    assert tried(space, FIRST) == {*every, (None, None, 0.6)}
    assert tried(space, FIRST._replace(seconds=0.604)) == set()  # as good as the same
    assert tried(space, FIRST._replace(seconds=0.9)) == {("Run command", "read", 0.9)}
    assert tried(space, FIRST._replace(address=VOLTAGE)) == set()
    assert len(tried(space, FIRST._replace(seconds=0.3))) == len(every) + 1


def test_nothing_is_later_than_the_weather_allows(space):
    assert tried(space, FIRST._replace(seconds=2.1)) == set()


def test_the_free_search_tries_it_too(space):
    (option,) = [each for each in space.options if each.fault == "sdo_late"]
    assert space.delayed(option) == []
    tried(space, FIRST)
    assert {each["seconds"] for each in space.delayed(option)} == {0.6}


class Busy(topcon.Device):
    """A device of somebody else, with a fault of his own."""

    @property
    def faults(self):
        delay = Parameter("by how much, in s", 0.1, low=0, high=1, delays_answers=True)
        text = "Its answers take longer."
        return {"busy": Fault(text, lambda delay: None, lambda delay: None, {"delay": delay})}


def test_a_fault_of_a_device_that_delays_answers_is_tried_when_all_is_well(space):
    scenario = Contract(Path("contract.yaml"), "my_master:main").scenario(Plan())
    nodes = {"topcon": replace(scenario.nodes["topcon"], device=Busy)}
    wanted = replace(scenario.space, faults=("busy",))
    space = Space(replace(scenario, nodes=nodes, space=wanted), space.events)
    waits = [FIRST, FIRST._replace(request=2, seconds=1.1)]  # which is more than it takes
    plans = [plan.disturbances for source in space.learn(waits) for plan in source]
    assert plans == [({"at": 2.0, "inject": {"busy": {"delay": 0.6}}},)]


def test_a_run_tells_what_it_has_shown(space):
    lost = {"at": 0.0, "inject": {"sdo_silence": {"times": 1}}}
    contract = Contract(Path("contract.yaml"), "my_master:main")
    (wait,) = [each for each in run(contract, Plan((lost,))).waits if each.request == 1]
    assert wait == Wait("topcon", VOLTAGE, "read", 1, 0.1, 0.0)
    assert run(contract, Plan()).waits == ()
