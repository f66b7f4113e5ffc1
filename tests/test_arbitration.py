"""Frames that are sent at one microsecond: who is on the bus first is for the file to say."""

import pytest
import yaml

from canopen_twins import load, play
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.segment import Segment
from canopen_twins.errors import UserError
from canopen_twins.hunt.contract import Contract, Plan
from canopen_twins.hunt.find import note_of
from canopen_twins.hunt.run import run_to_compare
from canopen_twins.hunt.shrink import Shrinker

SENT = [("left", "705#05"), ("right", "585#60"), ("right", "086#01"), ("master", "206#00")]


@pytest.mark.parametrize("bit_rate", [None, 500_000])
@pytest.mark.parametrize(
    ("first", "heard"),
    [
        ("", ["206#00", "585#60", "086#01", "705#05"]),
        ("left", ["705#05", "206#00", "585#60", "086#01"]),
        ("right", ["585#60", "086#01", "206#00", "705#05"]),
        ("master", ["206#00", "585#60", "086#01", "705#05"]),
    ],
)
def test_one_is_first_then_the_lowest_identifier_wins(first, heard, bit_rate):
    trace = [frame for _, frame in sent(SENT, first, bit_rate)]
    if bit_rate is None:
        assert trace == heard
    else:  # where frames take their time, those of one sender compete, too
        assert (trace[0], sorted(trace)) == (heard[0] if first else "086#01", sorted(heard))


def sent(frames, first, bit_rate=None):
    segment, heard = Segment(), []
    segment.first = first
    if bit_rate is not None:
        segment.limit(bit_rate)
    wires = {name: segment.master(name) for name, _ in frames}
    segment.listeners.append(lambda frame, sender: heard.append((sender, str(frame))))
    for name, text in frames:
        segment.clock.at(1.0, lambda name=name, text=text: wires[name].put(Frame.parse(text)))
    segment.advance(2.0)
    return heard


def test_if_nobody_says_so_frames_go_as_they_were_sent():
    assert sent(SENT, None) == SENT


def test_what_is_sent_in_answer_competes_with_what_still_waits():
    segment, heard = Segment(), []
    segment.first = ""
    one, other = segment.master("one"), segment.master("other")

    def answer(frame, sender):
        heard.append(str(frame))
        if frame.can_id == 0x100:
            one.put(Frame.parse("300#"))

    segment.listeners.append(answer)
    segment.clock.at(
        1.0, lambda: [other.put(Frame.parse(text)) for text in ("100#", "200#", "400#")]
    )
    segment.advance(2.0)
    assert heard == ["100#", "200#", "300#", "400#"]


MASTER = """\
import time

import canopen


def main(network):
    network.add_node(5)
    time.sleep(1.0)
    network.send_message(0x705 + 1, [5])
    time.sleep(0.5)
"""
STORY = """\
version: 1
master: my_master:main
node: {device: topcon, node_id: 5}
duration: 2
steps:
  - {at: 0, write: {Producer Heartbeat Time: 500}}
"""


def trace(tmp_path, plan):
    (tmp_path / "my_master.py").write_text(MASTER)
    (tmp_path / "story.yaml").write_text(STORY)
    frames = run_to_compare(Contract(tmp_path / "story.yaml"), plan).frames
    return [line.split()[2] for line in frames if line.startswith("1000000 ")]


def test_the_frame_of_a_master_comes_before_or_after_that_of_a_node(tmp_path):
    assert trace(tmp_path, Plan(arbitration="master")) == ["master", "topcon"]
    assert trace(tmp_path, Plan(arbitration="identifier")) == ["topcon", "master"]
    assert trace(tmp_path, Plan(arbitration="topcon")) == ["topcon", "master"]


def test_nobody_else_is_first(tmp_path):
    (tmp_path / "story.yaml").write_text(STORY + "arbitration: topcom\n")
    with pytest.raises(UserError, match=r"unknown way of arbitration 'topcom'.* 'topcon'"):
        load(tmp_path / "story.yaml")


def test_a_find_says_so_in_its_file_and_its_note(tmp_path):
    (tmp_path / "my_master.py").write_text(MASTER)
    file = tmp_path / "story.yaml"
    expected = 'expect: {never: {frame: "706#*", from: master}}'
    file.write_text(f"{STORY}  - {{at: 0, {expected}}}\n")
    contract, plan = Contract(file), Plan(arbitration="identifier")
    assert yaml.safe_load(contract.text(plan))["arbitration"] == "identifier"
    result = run_to_compare(contract, plan)
    note = note_of(result.verdict, result.failures[0], plan)
    assert note.startswith("Of the frames of one microsecond the lowest identifier is first. ")
    assert plan.size == 1
    shrinker = Shrinker(result.failures[0], lambda plan: run_to_compare(contract, plan), 2)
    assert shrinker.shrink(plan).arbitration == ""  # which it does not need
    assert play(load(file)).kind == "FAIL"
