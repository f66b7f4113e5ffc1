"""Tables that users write in YAML; what is wrong with one is told in one line."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import yaml

from simulators.errors import UserError

LARGEST_FILE = 1 << 20  # bytes

Meaning = TypeVar("Meaning")


def read_table(path: Path, understand: Callable[[Any], Meaning]) -> Meaning:
    """What a file means, by a function that raises `ValueError` if it means nothing.

    Raises:
        UserError: there is no such file, it is no YAML, or it means nothing.
    """
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise ValueError(f"larger than {LARGEST_FILE} bytes")
        return understand(_values(path.read_text("utf-8")))
    except yaml.MarkedYAMLError as failure:
        mark = failure.problem_mark
        where = f":{mark.line + 1}:{mark.column + 1}" if mark else ""
        raise UserError(f"{path}{where}: {failure.problem}") from failure
    except (OSError, ValueError, yaml.YAMLError) as failure:
        reason = str(failure).splitlines()[0]
        raise UserError(f"{path}: {reason}") from failure


def _values(text: str) -> Any:
    """By libyaml if it is there, eight times as fast; what is wrong, the other one tells better."""
    try:
        return yaml.load(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except yaml.YAMLError:
        return yaml.safe_load(text)
