"""Scenarios: read from a file, played on a segment, and judged.

    schema.py   which keys there are         -> tables, and their JSON Schema
    compile.py  what the keys mean           -> a `Scenario` of `Step`s
    play.py     a run in simulated time      -> a `Player` on a `Segment`
    player/     steps at their moments,
                and who watches for signs    -> a `Verdict`

A step has a moment, an action (`actions`, `access`, `expect`) and a line of the file; what is
waited for or expected is a sign (`signs`). docs/explanation/how-a-scenario-is-judged.md has the
whole map. Bench files say in the same words who is on a bus.
"""

from canopen_twins.files.document import DocumentError as ScenarioError
from canopen_twins.scenario.load import load, load_bench
from canopen_twins.scenario.play import begin, finish, play, print_frames
from canopen_twins.scenario.player import Event, Player
from canopen_twins.scenario.scenario import Scenario
from canopen_twins.scenario.verdict import Kind, Outcome, Verdict

__all__ = [
    "Event",
    "Kind",
    "Outcome",
    "Player",
    "Scenario",
    "ScenarioError",
    "Verdict",
    "begin",
    "finish",
    "load",
    "load_bench",
    "play",
    "print_frames",
]
