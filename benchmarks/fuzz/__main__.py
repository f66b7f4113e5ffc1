"""The nightly command: random lives of a device until so many frames have been sent."""

import argparse
import logging
import time
from collections.abc import Iterator
from pathlib import Path
from random import Random

from benchmarks.fuzz.events import (
    SHORT_WAITS,
    WAITS,
    Clear,
    Event,
    Frames,
    Power,
    Send,
    Wait,
    change,
    inject,
)
from benchmarks.fuzz.story import story
from benchmarks.fuzz.world import World

BURST, LIFE = 200, 20_000  # frames
NODE_ID = 5


def main() -> int:
    """1 for a device that has failed; its story is a scenario file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("devices", nargs="+", metavar="DEVICE")
    parser.add_argument("--frames", type=int, default=10_000_000, help="of each device")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    logging.disable(logging.ERROR)  # nonsense is what they are told all the time
    failed = [_failed(name, options.frames, options.seed) for name in options.devices]
    return int(any(failed))


def _failed(device: str, wanted: int, seed: int) -> bool:
    begun, sent = time.perf_counter(), 0
    while sent < wanted:
        world = World(device, node_id=NODE_ID)
        try:
            live(world, Random(f"{device} {seed}"), min(LIFE, wanted - sent))
        except Exception as failure:
            path = Path(f"{Path(device).stem}_{seed}.twin.yaml")
            path.write_text(story(world, failure), "utf-8")
            print(f"{device}: seed {seed}: {failure!r}: canopen-twin play {path}")
            return True
        sent, seed = sent + world.frames, seed + 1
    seconds = time.perf_counter() - begun
    print(
        f"{device}: {sent} frames in {seconds:.0f} s, {sent / seconds:.0f} frames/s, nothing found"
    )
    return False


def live(world: World, random: Random, frames: int) -> None:
    """One life: bursts of frames, and between them whatever else may happen."""
    source = Frames(world.node, random)
    while world.frames < frames:
        for _ in range(BURST):
            world.do(Send(source.one()))
            if random.random() < 0.01:
                world.do(Wait(random.choice(SHORT_WAITS)))
        world.look()
        for event in _between(world, random):
            world.do(event)
    world.end()


def _between(world: World, random: Random) -> Iterator[Event]:
    chance = random.random()
    if chance < 0.2:
        yield from (inject(world.node.faults.known, random), Wait(random.choice(WAITS)))
    elif chance < 0.3:
        yield Clear()
    elif chance < 0.37:
        yield from (Clear(), Power(False), Wait(6.0), Power(True), Wait(1.0))
    elif chance < 0.5 and (changed := change(world.node.device, random)):
        yield changed
    else:
        yield from (Wait(random.choice(WAITS)), Send(Frames(world.node, random).nmt()))


if __name__ == "__main__":
    raise SystemExit(main())
