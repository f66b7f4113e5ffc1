import re
from pathlib import Path

from canopen_twins.devices.gateway.model.state import NEXT, GovernorCommand, MasterCommand, Trouble

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "devices" / "gateway.md").read_text("utf-8")


def words(trigger):
    """Who it comes from, and what it is."""
    match trigger:
        case GovernorCommand():
            return f"governor {trigger.value}"
        case MasterCommand():
            return f"NMT {trigger.value:02X}h"
        case Trouble():
            return trigger.value


def diagram():
    """The state machine in the words of Mermaid; what changes nothing is not drawn."""
    lines = ["stateDiagram-v2", "    [*] --> UNDEFINED: 200 ms after power-on or reset"]
    for state, row in NEXT.items():
        arrows = {}
        for trigger, after in row.items():
            if after is not state:
                arrows.setdefault(after.name, []).append(words(trigger))
        lines += [f"    {state.name} --> {name}: {', '.join(by)}" for name, by in arrows.items()]
    return "\n".join(lines)


def test_the_picture_of_the_states_is_that_of_the_table():
    (drawn,) = re.findall(r"```mermaid\n(.*?)\n```", PAGE, re.DOTALL)
    assert drawn == diagram()


def test_every_assumption_is_told_once_and_says_how_to_change_it_or_why_not():
    rows = re.findall(r"^\| A-(\d+) \| .* \| (.*) \|$", PAGE, re.MULTILINE)
    assert [int(number) for number, _ in rows] == list(range(1, len(rows) + 1))
    for number, setting in rows:
        assert setting.startswith(("fixed: ", "`")), number


def test_every_assumption_the_code_names_is_told():
    told = set(re.findall(r"^\| (A-\d+) \|", PAGE, re.MULTILINE))
    files = [
        *ROOT.glob("simulators/canopen_twins/devices/gateway/**/*.py"),
        *ROOT.glob("od/gateway*"),
        *ROOT.glob("scenarios/gateway*"),
    ]
    named = {number for file in files for number in re.findall(r"A-\d\d", file.read_text("utf-8"))}
    assert named <= told


def test_the_misprints_of_the_eds_are_told():
    comment = (ROOT / "od" / "gateway.eds").read_text("ascii")
    comment = comment.partition("[Comments]")[2].partition("[MandatoryObjects]")[0]
    for misprint in ("0x0x00001B59", "Defaultvalue", "SimpleBoot-up"):
        assert misprint in comment
        assert f"`{misprint}`" in PAGE
