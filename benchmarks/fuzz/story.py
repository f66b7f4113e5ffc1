"""A failure as a scenario file: as few events as bring it about, and what was expected."""

from collections.abc import Callable, Sequence
from typing import Any

import yaml

from benchmarks.fuzz.events import Change, Clear, Event, Inject, Power, Send, Wait
from benchmarks.fuzz.world import ENDING, BrokenError, World

MOST_LIVES = 400  # until it is short enough
LASTING = {"never": {"frame": "7FF#*"}}  # so that the life lasts
MOMENT = 0.000_001  # seconds: a frame is answered at the moment it comes


def live(device: str, settings: dict[str, Any], events: Sequence[Event]) -> Exception | None:
    """What goes wrong in a life, none if nothing does."""
    world = World(device, **settings)
    try:
        for event in events:
            world.do(event)
        world.look()
        if tuple(events[-len(ENDING) :]) == ENDING:
            world.compare()
    except Exception as failure:
        return failure
    return None


def kind(failure: Exception) -> str:
    """What two failures have in common that are one."""
    return failure.kind if isinstance(failure, BrokenError) else type(failure).__name__


def shortened(events: Sequence[Event], fails: Callable[[Sequence[Event]], bool]) -> list[Event]:
    """Without all events that are not needed for it to fail, as far as `MOST_LIVES` go."""
    kept, lives, part = list(events), 0, len(events) // 2
    while part and lives < MOST_LIVES:
        place = 0
        while place < len(kept) and lives < MOST_LIVES:
            without = kept[:place] + kept[place + part :]
            lives += 1
            if fails(without):
                kept = without
            else:
                place += part
        part //= 2
    return kept


def story(world: World, failure: Exception) -> str:
    """A scenario that `play` fails, or that brings the bug to light."""
    wanted = kind(failure)

    def fails(events: Sequence[Event]) -> bool:
        seen = live(world.device, world.settings, events)
        return seen is not None and kind(seen) == wanted

    events = shortened(world.events, fails) if fails(world.events) else world.events
    last = live(world.device, world.settings, events) or failure
    settings = dict(world.settings)
    node = {"device": world.device, "node_id": settings.pop("node_id"), "settings": settings}
    whole = {
        "version": 1,
        "name": f"A random life: {wanted}",
        "note": f"{type(last).__name__}: {last}",
        "node": {key: value for key, value in node.items() if value},
        "steps": _steps(events, last),
    }
    return yaml.safe_dump(whole, sort_keys=False, allow_unicode=True)


def _steps(events: Sequence[Event], failure: Exception) -> list[dict[str, Any]]:
    """What must never be seen is watched for just before the last event, a value is read behind."""
    steps, now = [], 0.0
    for event in events[:-1]:
        if isinstance(event, Wait):
            now = round(now + event.seconds, 6)
        else:
            steps.append({"at": now, **_verb(event)})
    last = events[-1]
    lasts = last.seconds if isinstance(last, Wait) else 2 * MOMENT
    expect = failure.expect if isinstance(failure, BrokenError) else None
    again = failure.again if isinstance(failure, BrokenError) else None
    ending = [] if isinstance(last, Wait) else [{"at": now, **_verb(last)}]
    if expect is None:
        return [*steps, *ending, {"at": now, "expect": {**LASTING, "within": lasts}}]
    if again is not None:
        when = {"when": {"frame": str(again)}, "expect": {**expect, "within": lasts}}
        return [*steps, *ending, when]
    if "never" not in expect:
        return [*steps, *ending, {"at": round(now + lasts, 6), "expect": dict(expect)}]
    now = round(now + MOMENT, 6)  # what was sent before at this moment would count
    watch = {"at": now, "expect": {**expect, "within": lasts}}
    return [*steps, watch, *({**each, "at": round(now + MOMENT, 6)} for each in ending)]


def _verb(event: Event) -> dict[str, Any]:
    match event:
        case Send(frame):
            return {"send": str(frame)}
        case Inject(fault, parameters):
            return {"inject": {fault: dict(parameters)}}
        case Power(on):
            return {"power": "on" if on else "off"}
        case Change(settings):
            return {"set": dict(settings)}
        case Clear():
            return {"clear": "all"}
    raise TypeError(event)
