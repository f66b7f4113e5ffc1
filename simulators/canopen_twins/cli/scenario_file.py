"""The scenario that a user names: a file, or one that is shipped."""

from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path

from canopen_twins import scenario as rules
from canopen_twins.errors import unknown
from canopen_twins.files.shipped import scenario_file, scenarios


def load(name: str) -> rules.Scenario:
    """A scenario from a file, or one that is shipped; verdicts call it as the user does.

    Raises:
        UserError: there is neither, or something is wrong with it.
    """
    with found(name) as path:
        if not path.exists() and path.name == name:
            raise unknown("file or shipped scenario", name, scenarios())
        return replace(rules.load(path), file=Path(name))


def found(name: str) -> AbstractContextManager[Path]:
    """The path of a scenario; one that is shipped has a path only meanwhile."""
    if name in scenarios() and not Path(name).exists():
        return scenario_file(name)
    return nullcontext(Path(name))
