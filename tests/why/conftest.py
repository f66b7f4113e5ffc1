from collections.abc import Callable

import pytest

from canopen_twins import Bench
from canopen_twins.diagnosis.why import why


@pytest.fixture
def topcon() -> Bench:
    """A TopCon as node 5, in Pre-operational."""
    return Bench("topcon", node_id=5)


@pytest.fixture
def charger() -> Bench:
    """A charger as node 9, in Pre-operational."""
    return Bench("charger", node_id=9)


@pytest.fixture
def reasons() -> Callable[..., list[str]]:
    """Why the twin of a bench answered as it did to some frames, sent one after the other."""

    def reasons(bench, *frames, expected=None):
        for frame in frames:
            bench.send(frame)
        return why(bench.twin.node, bench.trace[-20:], expected=expected)

    return reasons
