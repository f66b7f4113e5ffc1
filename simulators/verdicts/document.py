"""Verdicts as one JSON document of a shape that stays: see docs/reference/verdicts.md."""

import json
from collections.abc import Mapping, Sequence

from simulators.replay import Kind, Outcome, Verdict

VERSION = 1


def document(verdicts: Sequence[Verdict]) -> str:
    """In one line, for whoever reads line by line."""
    return json.dumps(
        {
            "version": VERSION,
            "verdict": max((each.kind for each in verdicts), key=list(Kind).index).value,
            "scenarios": [_scenario(verdict) for verdict in verdicts],
        }
    )


def _scenario(verdict: Verdict) -> Mapping[str, object]:
    return {
        "file": verdict.file,
        "name": verdict.name,
        "verdict": verdict.kind.value,
        "seed": verdict.seed,
        "duration": verdict.seconds,
        "outcomes": [_outcome(outcome) for outcome in verdict.outcomes],
    }


def _outcome(outcome: Outcome) -> Mapping[str, object]:
    return {
        "verdict": outcome.kind.value,
        "time": outcome.time,
        "line": outcome.line,
        "what": outcome.what,
        "seen": outcome.seen,
        "note": outcome.note,
        "scene": outcome.scene,
    }
