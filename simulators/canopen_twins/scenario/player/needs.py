"""Which signs a scenario will ever watch for, and at which nodes."""

from collections.abc import Iterator

from canopen_twins.scenario.actions import Inject
from canopen_twins.scenario.expect import Expectation
from canopen_twins.scenario.matchers import Sign
from canopen_twins.scenario.scenario import Condition, Scenario, Step


def needs(scenario: Scenario) -> Iterator[tuple[str, Sign]]:
    """The names of nodes and the signs that are watched for there."""
    for step in (*scenario.steps, *scenario.cleanup):
        if isinstance(step.action, Expectation):
            yield step.node, step.action.sign
        for condition in _conditions(step):
            yield condition.node, condition.what


def _conditions(step: Step) -> Iterator[Condition]:
    action = step.action
    heals = action.lasts if isinstance(action, Inject) else None
    ends = action.before if isinstance(action, Expectation) else None
    for moment in (step.moment, heals, ends):
        if isinstance(moment, Condition):
            yield moment
