"""The examples of the documentation that are device files, and what becomes of damaged ones."""

import shutil
from contextlib import suppress
from io import StringIO
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from canopen_twins import Bench, UserError, load, play
from canopen_twins.cli import main
from canopen_twins.scenario import Kind

from .conftest import EXAMPLES

FOLDERS = ("battery", "io-block")
STORIES = [path for folder in FOLDERS for path in sorted(EXAMPLES.glob(f"{folder}/*.twin.yaml"))]


@pytest.mark.parametrize("path", STORIES, ids=lambda path: path.name)
def test_its_story_passes_and_leaves_the_same_trace(path):
    traces = StringIO(), StringIO()
    for trace in traces:
        verdict = play(load(path), trace)
        assert {outcome.kind for outcome in verdict.outcomes} == {Kind.PASS}, str(verdict)
    assert traces[0].getvalue() == traces[1].getvalue()


@pytest.mark.parametrize("folder", FOLDERS)
def test_there_is_nothing_unusual_in_it(folder, capsys):
    files = sorted(EXAMPLES.glob(f"{folder}/*.yaml")) + sorted(EXAMPLES.glob(f"{folder}/*.eds"))
    assert main(["check", *map(str, files)]) == 0
    assert capsys.readouterr().out.splitlines() == [f"{file}: ok" for file in files]


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_story_has_every_fault_and_every_emergency(folder):
    (device,) = EXAMPLES.glob(f"{folder}/*.device.yaml")
    told = "".join(path.read_text("utf-8") for path in EXAMPLES.glob(f"{folder}/*.twin.yaml"))
    twin = Bench(str(device)).device
    assert [name for name in twin.faults if name not in told] == []
    codes = {f"0x{message.code:04X}" for message in twin.messages.values()}
    assert [code for code in codes if code not in told] == []


@st.composite
def damaged(draw):
    """An example with lines dropped, doubled and swapped, and characters replaced."""
    (path,) = EXAMPLES.glob(f"{draw(st.sampled_from(FOLDERS))}/*.device.yaml")
    lines = path.read_text("utf-8").splitlines()
    for _ in range(draw(st.integers(1, 3))):
        one, other = (draw(st.integers(0, len(lines) - 1)) for _ in range(2))
        kind = draw(st.sampled_from(("drop", "double", "swap", "replace")))
        if kind == "drop":
            lines[one] = ""
        elif kind == "double":
            lines.insert(one, lines[one])
        elif kind == "swap":
            lines[one], lines[other] = lines[other], lines[one]
        elif lines[one]:
            place = draw(st.integers(0, len(lines[one]) - 1))
            sign = draw(st.sampled_from("0159-.:,{}[]#'\"eExX \t"))
            lines[one] = f"{lines[one][:place]}{sign}{lines[one][place + 1 :]}"
    return path.parent, "\n".join(lines)


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(damaged())
def test_a_damaged_file_is_a_twin_or_a_mistake_of_its_author(tmp_path, file):
    folder, text = file
    for path in folder.iterdir():
        if path.is_file():
            shutil.copy(path, tmp_path)
    path = Path(tmp_path, "damaged.device.yaml")
    path.write_text(text, "utf-8")
    with suppress(UserError):
        Bench(str(path)).run(3)
