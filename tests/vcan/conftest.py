from contextlib import ExitStack

import pytest

from canopen_twins.bus import vcan
from tests.vcan.bus import Candump, Twin, master


def pytest_runtest_setup(item):
    if item.get_closest_marker("vcan") and not vcan.is_up():
        pytest.skip("no vcan0: tests/vcan/run python -m pytest -m vcan")


@pytest.fixture
def stack():
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def run(stack):
    """Start a twin as a user does; it has to end as it was told and without a word on stderr."""
    return lambda *words, **options: stack.enter_context(Twin(*words, **options))


@pytest.fixture
def candump(stack):
    """A foreign witness of everything on the bus."""
    return stack.enter_context(Candump())


@pytest.fixture
def network(stack):
    """A canopen master in this process."""
    return stack.enter_context(master())
