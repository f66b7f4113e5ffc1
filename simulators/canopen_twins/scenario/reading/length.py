"""Whether a run is long enough for what must never come in it."""

from collections.abc import Sequence

from canopen_twins.errors import UserError
from canopen_twins.scenario.actions import Expectation, Inject
from canopen_twins.scenario.matchers import Condition
from canopen_twins.scenario.scenario import After, At, Step
from canopen_twins.scenario.schema import AnyStep

IN_VAIN = (
    "the run may be over as soon as this begins, so that nothing is watched: "
    "give it 'within', or the file a 'duration'"
)


def check_length(told: Sequence[AnyStep], steps: Sequence[Step], duration: float | None) -> None:
    """Note as a problem what would watch to the end of a run that is over then.

    A step that waits for a condition comes at its earliest, so that some of it is not found.
    """
    begins = _begins(steps)
    places = [each.place for each in told]
    length = max([duration or 0.0, *map(_end, steps, begins)])
    for number, (place, step, begin) in enumerate(zip(places, steps, begins, strict=True)):
        with place.problems.at(place):
            if not _open(step) or length > begin:
                continue
            if duration is not None or not _waits(steps, number):
                raise UserError(IN_VAIN)


def _begins(steps: Sequence[Step]) -> list[float]:
    """Seconds at which each step begins, or before which it does not."""
    begins: list[float] = []
    begin = end = 0.0
    for step in steps:
        if isinstance(step.moment, At):
            begin = step.moment.seconds
        elif isinstance(step.moment, After):
            begin = end + step.moment.seconds
        end = begin + (step.times - 1) * step.every
        begins.append(begin)
    return begins


def _end(step: Step, begin: float) -> float:
    """Seconds up to which it keeps the run going."""
    action, lasts = step.action, 0.0
    if isinstance(action, Expectation):
        lasts = action.seconds or 0.0
    elif isinstance(action, Inject) and isinstance(action.lasts, float):
        lasts = action.lasts
    return begin + (step.times - 1) * step.every + lasts


def _open(step: Step) -> bool:
    """Whether only the end of the run ends it."""
    action = step.action
    return isinstance(action, Expectation) and action.seconds is None and action.before is None


def _waits(steps: Sequence[Step], number: int) -> bool:
    """Whether others wait for a condition while one watches."""
    ends = (step.action.before for step in steps if isinstance(step.action, Expectation))
    below = (step.moment for step in steps[number + 1 :])
    return any(isinstance(each, Condition) for each in (*ends, *below))
