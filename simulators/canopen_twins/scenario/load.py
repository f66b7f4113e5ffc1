"""Scenarios and bench files, by their paths; pydantic is imported when the first one is read."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from canopen_twins import devices
from canopen_twins.scenario.scenario import NodeSpec, Scenario

if TYPE_CHECKING:
    from canopen_twins.scenario.rehearsal import Find


def load(path: str | Path, find: Find = devices.find, text: str | None = None) -> Scenario:
    """The scenario of a file.

    Args:
        path: Of the file.
        find: The class of a device by its name, or by the path of a file that describes one; raises
            `UserError` if there is none.
        text: What would stand in the file; None: what does.

    Raises:
        ScenarioError: with a line for everything that is wrong.
    """
    from canopen_twins.scenario.compile import read_scenario  # noqa: PLC0415

    return read_scenario(Path(path), find, text)


def load_bench(path: Path, find: Find = devices.find) -> Mapping[str, NodeSpec]:
    """The nodes of a bench file, by their names there.

    Args:
        path: Of the file.
        find: As for `load`.

    Raises:
        ScenarioError: with a line for everything that is wrong; two nodes may have one node id.
    """
    from canopen_twins.scenario.compile import read_bench  # noqa: PLC0415

    return read_bench(path, find)
