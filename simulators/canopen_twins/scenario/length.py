"""Whether a run is long enough for what must never come in it."""

from collections.abc import Sequence

from canopen_twins.errors import UserError
from canopen_twins.files.document import Item
from canopen_twins.scenario.actions import Expectation, Inject
from canopen_twins.scenario.matchers import Condition
from canopen_twins.scenario.scenario import After, At, Step

IN_VAIN = (
    "the run may be over as soon as this begins, so that nothing is watched: "
    "give it 'within', or the file a 'duration'"
)


def check_length(places: Sequence[Item], steps: Sequence[Step], duration: float | None) -> None:
    """What would watch to the end of a run that is over then becomes a problem.

    A step that waits for a condition comes at its earliest, so that some of it is not found.
    """
    begins = _begins(steps)
    length = max([duration or 0.0, *map(_end, steps, begins)])
    for number, (place, step, begin) in enumerate(zip(places, steps, begins, strict=True)):
        in_vain = _is_open(step) and length <= begin
        if in_vain and (duration is not None or not _is_waited_for(steps, number)):
            place.problems.add(UserError(IN_VAIN), place.mark)


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


def _is_open(step: Step) -> bool:
    """Whether only the end of the run ends it."""
    action = step.action
    return isinstance(action, Expectation) and action.seconds is None and action.before is None


def _is_waited_for(steps: Sequence[Step], number: int) -> bool:
    """Whether others wait for a condition while one watches."""
    ends = (step.action.before for step in steps if isinstance(step.action, Expectation))
    below = (step.moment for step in steps[number + 1 :])
    return any(isinstance(each, Condition) for each in (*ends, *below))
