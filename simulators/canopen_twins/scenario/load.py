"""Scenarios and bench files, by their paths; pydantic is imported when the first one is read."""

from collections.abc import Callable, Mapping
from pathlib import Path

from canopen_twins import devices
from canopen_twins.device.device import Device
from canopen_twins.scenario.scenario import NodeSpec, Scenario

Find = Callable[[str], type[Device]]


def load(path: str | Path, find: Find = devices.find) -> Scenario:
    """The scenario of a file.

    Args:
        path: Of the file.
        find: The class of a device by its name; raises `UserError` if there is none.

    Raises:
        ScenarioError: with a line for everything that is wrong.
    """
    from canopen_twins.scenario.reading.scenario import read_scenario  # noqa: PLC0415

    return read_scenario(Path(path), find)


def load_bench(path: Path, find: Find = devices.find) -> Mapping[str, NodeSpec]:
    """The nodes of a bench file, by their names there.

    Args:
        path: Of the file.
        find: As for `load`.

    Raises:
        ScenarioError: with a line for everything that is wrong; two nodes may have one node id.
    """
    from canopen_twins.scenario.reading.scenario import read_bench  # noqa: PLC0415

    return read_bench(path, find)
