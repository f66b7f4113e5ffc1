"""The JSON Schema of the files that users write, for their editors."""

import argparse
import json
from collections.abc import Mapping

from canopen_twins.files.table import Table, json_schema
from canopen_twins.scenario.schema import BenchFile, ScenarioFile

FILES: Mapping[str, type[Table]] = {"scenario": ScenarioFile, "bench": BenchFile}


def schema(options: argparse.Namespace) -> int:
    """Print it."""
    print(json.dumps(json_schema(FILES[options.file]), indent=2))
    return 0
