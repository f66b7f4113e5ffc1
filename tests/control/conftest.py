from collections.abc import Iterator
from pathlib import Path

import pytest

from .served import Port, served

BATTERY = str(Path(__file__).parents[2] / "docs" / "examples" / "battery" / "battery.device.yaml")


@pytest.fixture(scope="module")
def port() -> Iterator[Port]:
    """The port of a TopCon, a gateway and a battery, the same for all tests of a file."""
    nodes = {
        "topcon": ("topcon", {"node_id": 5}),
        "engine": ("gateway", {}),
        "battery": (BATTERY, {"node_id": 9}),
    }
    with served(nodes) as port:
        while not port.get("/nodes/engine/values").body:  # its gateway is still waiting for it
            pass
        yield port


@pytest.fixture(autouse=True)
def as_before(request: pytest.FixtureRequest) -> Iterator[None]:
    """Each test finds it without a fault."""
    yield
    if "port" in request.fixturenames:
        request.getfixturevalue("port")("DELETE", "/nodes/topcon/faults")
