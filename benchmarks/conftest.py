from importlib.metadata import version
from typing import Any

PACKAGES = ("canopen", "python-can")


def pytest_benchmark_update_machine_info(config: object, machine_info: dict[str, Any]) -> None:
    """Note with the figures what else they depend on."""
    machine_info["packages"] = {name: version(name) for name in PACKAGES}
