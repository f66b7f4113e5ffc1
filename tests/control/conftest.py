from collections.abc import Iterator

import pytest

from .served import Port, served


@pytest.fixture(scope="module")
def port() -> Iterator[Port]:
    """The port of a TopCon and a gateway, the same for all tests of a file."""
    with served({"topcon": ("topcon", {"node_id": 5}), "engine": ("gateway", {})}) as port:
        yield port


@pytest.fixture(autouse=True)
def as_before(request: pytest.FixtureRequest) -> Iterator[None]:
    """Each test finds it without a fault."""
    yield
    if "port" in request.fixturenames:
        request.getfixturevalue("port")("DELETE", "/nodes/topcon/faults")
