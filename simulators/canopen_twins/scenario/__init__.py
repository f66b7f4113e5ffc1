"""Scenarios: read from a file, played on a segment, and judged.

    schema.py   which keys there are, each value read once    -> tables, and their JSON Schema
    compile.py  what the keys mean                            -> a `Scenario` of `Step`s
    play, player  a run: steps at their moments               -> a `Verdict`

A step has a moment, an action (`actions`) and a line of the file; what is waited for or expected is
a matcher (`matchers`). docs/explanation/how-a-scenario-is-judged.md has the whole map. Bench files
say in the same words who is on a bus.
"""

from canopen_twins.files.document import DocumentError as ScenarioError
from canopen_twins.scenario.load import load, load_bench
from canopen_twins.scenario.play import begin, finish, play, print_frames
from canopen_twins.scenario.player import Player
from canopen_twins.scenario.run_log import PlayerEvent
from canopen_twins.scenario.scenario import Scenario
from canopen_twins.scenario.verdict import Kind, Outcome, Verdict

__all__ = [
    "Kind",
    "Outcome",
    "Player",
    "PlayerEvent",
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
