"""A hub under load: `python -m benchmarks.crowd --clients 200 --seconds 60`.

Clients of six kinds want to be on it, more than it takes at a time: one who sends at a steady pace
and readers, who are there first; deaf ones who never read, flooders on a bus of their own,
babblers who speak another protocol, and guests who come and go.

Invariants: each reader hears each frame of the steady one, once, in order and soon; the hub keeps
its memory, takes a new client afterwards, ends when it is told to, and has no bug to tell of.
`--python` has the hub run by another interpreter.
"""

import argparse
import asyncio
import sys
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from itertools import cycle, islice
from multiprocessing import Process

from benchmarks.processes import PATIENCE, judged, percentiles, watched
from canopen_twins.bus.hub.protocol import HubAddress, Stream, element, read_delivered

BUS, FLOODED = "crowd", "flood"
READERS = 8
STEADY_ID = 0x123
MOST_MEMORY = 200.0  # MB
SLOWEST = 5.0  # seconds for 99 % of the frames, on a machine that does all this at once
SETTLED = 0.5  # seconds
DEAF = 30.0  # seconds until somebody else who never reads takes the place


Joined = tuple[asyncio.StreamReader, asyncio.StreamWriter]


async def joined(address: HubAddress, bus: str) -> Joined:
    """A connection that is on a bus; raises `ConnectionRefusedError` if it is sent away."""
    reader, writer = await asyncio.open_connection(*address)
    for text in (f"open {bus}", "rawmode", ""):
        if b"error" in await reader.readuntil(b">"):
            writer.close()
            raise ConnectionRefusedError
        if text:
            writer.write(element(text))
    return reader, writer


class Others:
    """The crowd, in a process of its own: what it costs is not the hub's."""

    def __init__(self, address: HubAddress, deaf_only: bool) -> None:
        self._address = address
        kinds: list[Callable[[], Awaitable[None]]] = [self._deaf]
        self._kinds = kinds if deaf_only else [*kinds, self._flood, self._babble, self._visit]

    async def live(self, clients: int) -> None:
        """Until somebody ends the process."""
        await asyncio.gather(*map(self._again, islice(cycle(self._kinds), clients)))

    async def _again(self, kind: Callable[[], Awaitable[None]]) -> None:
        while True:
            with suppress(OSError, asyncio.IncompleteReadError):
                await kind()
            await asyncio.sleep(0.2)

    async def _deaf(self) -> None:
        _, writer = await joined(self._address, BUS)
        writer.transport.pause_reading()  # type: ignore[attr-defined]
        await asyncio.sleep(DEAF)
        writer.transport.abort()

    async def _flood(self) -> None:
        _, writer = await joined(self._address, FLOODED)
        while True:
            writer.write(element("send 181 8 1 2 3 4 5 6 7 8") * 100)
            await writer.drain()
            await asyncio.sleep(0)

    async def _babble(self) -> None:
        reader, writer = await asyncio.open_connection(*self._address)
        writer.write(b"GET / HTTP/1.1\r\n\r\n" * 100)
        with suppress(ConnectionError):
            await reader.read()
        writer.close()

    async def _visit(self) -> None:
        reader, writer = await joined(self._address, BUS)
        await reader.read(1 << 10)
        writer.transport.abort()


def _others(address: HubAddress, options: argparse.Namespace) -> None:
    others = Others(address, options.deaf_only)
    asyncio.run(others.live(options.clients - READERS - 1))


class Measured:
    """Who sends at a steady pace, and its readers: what they have heard, and how late."""

    def __init__(self, address: HubAddress, options: argparse.Namespace) -> None:
        self._address = address
        self._options = options
        self.sent: list[float] = []
        self.heard: list[list[int]] = []
        self.latencies: list[float] = []
        self.newcomer = 0.0
        """Seconds for a client to get on the hub, after everybody has gone."""

    async def live(self) -> None:
        """Until the time is over, and the last frames have been heard."""
        steady = await joined(self._address, BUS)
        each = [await joined(self._address, BUS) for _ in range(READERS)]
        readers = [asyncio.create_task(self._read(reader)) for reader in each]
        crowd = Process(target=_others, args=(self._address, self._options), daemon=True)
        crowd.start()
        await asyncio.sleep(SETTLED)  # a hub keeps back for a moment what comes first
        await self._send(steady)
        end = time.monotonic() + PATIENCE
        while min(map(len, self.heard)) < len(self.sent) and time.monotonic() < end:
            await asyncio.sleep(SETTLED)
        crowd.terminate()
        crowd.join()
        for task in readers:
            task.cancel()
        for outcome in await asyncio.gather(*readers, return_exceptions=True):
            if isinstance(outcome, Exception):
                raise outcome
        for _, writer in (steady, *each):
            writer.close()
        await asyncio.sleep(SETTLED)
        begun = time.monotonic()
        (await joined(self._address, BUS))[1].close()
        self.newcomer = time.monotonic() - begun

    async def _send(self, steady: Joined) -> None:
        begun = time.monotonic()
        while (now := time.monotonic()) < begun + self._options.seconds:
            while len(self.sent) < (now - begun) * self._options.rate:
                data = len(self.sent).to_bytes(8, "little")
                steady[1].write(element(f"send {STEADY_ID:X} 8 {data.hex(' ')}"))
                self.sent.append(time.monotonic())
            await steady[1].drain()
            await asyncio.sleep(0.001)

    async def _read(self, reader: Joined) -> None:
        heard: list[int] = []
        self.heard.append(heard)
        stream = Stream()
        while data := await reader[0].read(1 << 16):
            now = time.monotonic()
            for text in stream.feed(data):
                frame = read_delivered(text)
                if frame is not None and frame.can_id == STEADY_ID:
                    number = int.from_bytes(frame.data, "little")
                    heard.append(number)
                    self.latencies.append(now - self.sent[number])


def main() -> int:
    """1 if an invariant does not hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clients", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--rate", type=float, default=500.0, help="frames a second, of the steady")
    parser.add_argument("--deaf-only", action="store_true", help="no other kind in the crowd")
    parser.add_argument("--python", default=sys.executable, metavar="PROGRAM", help="of the hub")
    options = parser.parse_args()
    with watched("hub", "--listen", "127.0.0.1:0", python=options.python) as hub:
        address = HubAddress(hub.told["host"], hub.told["port"])
        crowd = Measured(address, options)
        asyncio.run(crowd.live())
        memory, seconds = hub.memory, hub.seconds
        code = hub.end()
        bugs = [line.strip() for line in hub.said if "Traceback" in line or "Error" in line]
    everything = list(range(len(crowd.sent)))
    wrong = sum(heard != everything for heard in crowd.heard)
    print(f"{options.clients} clients, {options.seconds:.0f} s")
    print(f"{len(everything)} frames to {READERS} readers: {percentiles(crowd.latencies)}")
    print(
        f"hub: {seconds:.1f} s of a core, {memory:.0f} MB; a newcomer waits {crowd.newcomer:.3f} s"
    )
    slow = sorted(crowd.latencies)[int(0.99 * len(crowd.latencies))]
    return judged(
        [
            *([f"{wrong} readers have not heard all, once, in order"] if wrong else []),
            *([f"1 % of the frames come after {slow:.1f} s"] if slow > SLOWEST else []),
            *([f"the hub has {memory:.0f} MB"] if memory > MOST_MEMORY else []),
            *([f"the hub ends with {code}"] if code else []),
            *bugs,
        ]
    )


if __name__ == "__main__":
    sys.exit(main())
