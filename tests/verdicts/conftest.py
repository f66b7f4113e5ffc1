import pytest

from canopen_twins.scenario import Kind, Outcome, Verdict

SCENE = "    0.000000  topcon      705#00   boot-up\ntopcon: node 5, PRE-OPERATIONAL"


@pytest.fixture
def verdict():
    """One with an outcome of every kind, and a fault that struck twice."""
    return Verdict(
        "stories/all.yaml",
        (
            Outcome(Kind.PASS, 0.1, 5, "705#00 at once", "705#00"),
            Outcome(
                Kind.FAIL, 0.25, 6, "no EMCY for 1 s", "2300/03/23", "A note.", SCENE, "topcon"
            ),
            Outcome(Kind.ERROR, 2.0, 8, "write X = 3", "X is refused", "", SCENE),
            Outcome(Kind.ERROR, 3.0, 8, "write X = 3", "X is refused", "", SCENE),
            Outcome(Kind.SKIP, 3.0, 9, "nmt", "left out"),
        ),
        name="Everything at once",
        seed=7,
        seconds=12.5,
    )
