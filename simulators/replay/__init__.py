"""Scenario files: a story about a device, told in YAML, played on its twin, and judged.

Bench files say in the same words who else is on a bus.
"""

from simulators.documents.problems import DocumentError as ScenarioError
from simulators.replay.load import load, load_bench
from simulators.replay.play import begin, finish, play
from simulators.replay.player import Event, Player
from simulators.replay.scenario import Scenario
from simulators.replay.verdict import Kind, Outcome, Verdict

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
]
