"""Scenario files: a story about a device, told in YAML, played on its twin, and judged."""

from simulators.documents.problems import DocumentError as ScenarioError
from simulators.replay.load import load
from simulators.replay.play import play
from simulators.replay.player import Player
from simulators.replay.scenario import Scenario
from simulators.replay.verdict import Kind, Outcome, Verdict

__all__ = ["Kind", "Outcome", "Player", "Scenario", "ScenarioError", "Verdict", "load", "play"]
