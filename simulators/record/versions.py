"""Versions of everything that has a say in what is on a bus."""

import platform
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, entry_points, version

from simulators.devices import GROUP

PACKAGES = ("canopen-twins", "canopen", "python-can")
PYTHON = "python"


def versions(devices: Iterable[str]) -> dict[str, str]:
    """By the names of packages, also of those that bring some of the devices."""
    owners = {
        entry.dist.name
        for name in devices
        for entry in entry_points(group=GROUP, name=name)
        if entry.dist is not None
    }
    return {name: version_now(name) for name in (*PACKAGES, *sorted(owners), PYTHON)}


def version_now(name: str) -> str:
    """The version of a package, or of Python, that is here."""
    if name == PYTHON:
        return platform.python_version()
    try:
        return version(name)
    except PackageNotFoundError:
        return "none"
