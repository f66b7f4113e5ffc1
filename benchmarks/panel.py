"""Eight nodes at 1,000 frames/s with their page open: `python -m benchmarks.panel --seconds 5`.

TopCons in a process on a hub, a master in another that sends a SYNC every 9 ms, each with a TPDO of
every node, and reads objects in turn. Chromium without a window has the page closed, then open,
again and again; of what is told of a round the median over the rounds is printed. As the browser
takes the machine's time, too, what the process of the twins takes of a core says what the page
costs them. A click is on a node or on a fault, until the page shows its effect.

A row more is with somebody at the stream of all frames beside the page.
"""

import argparse
import json
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from http.client import HTTPConnection
from multiprocessing import Pipe, Process
from multiprocessing.connection import Connection
from pathlib import Path
from statistics import median, quantiles
from threading import Event, Thread
from typing import Any, NamedTuple

from benchmarks.processes import Watched, watched
from benchmarks.soak import Master
from canopen_twins.bus.hub.client import HubBus
from canopen_twins.bus.hub.protocol import HubAddress

NODES = 8
SWITCHES = ("headless=new", "no-sandbox", "disable-gpu", "disable-dev-shm-usage", "no-first-run")
PATIENCE = 20.0  # seconds for an effect
NAP = 0.002
STALLS = ("stood still", "left out")


class Round(NamedTuple):
    """What a round has shown."""

    frames: float
    """A second."""
    answers: Sequence[float]
    """Seconds from an SDO request to its answer."""
    share: float
    """Of a core, by the process of the twins."""
    clicks: Sequence[float] = ()
    """Seconds from a click to its effect."""
    streamed: int = 0
    lost: int = 0


def master(pipe: Connection, address: HubAddress, options: argparse.Namespace) -> None:
    """A process: works for as many seconds as it is told, and tells what it has seen."""
    with HubBus(address, "vcan0") as bus:
        them = Master(bus, options)
        them.configure()
        them.counts = True
        pipe.send(None)
        while (seconds := pipe.recv()) is not None:
            them.frames, them.answers = 0, []
            them.work(seconds, {})
            them.settle()
            pipe.send((them.frames, them.answers))


class Page:
    """A browser, and what a person does in it."""

    def __init__(self, browser: Any, address: str) -> None:
        self._browser, self._address = browser, address

    def open(self) -> None:
        """The page of the twins, until it shows one of them."""
        self._browser.get(self._address)
        self._wait("state-title", "n1, node 1")

    def close(self) -> None:
        """Nothing."""
        self._browser.get("about:blank")

    def clicks(self, end: float) -> Iterator[float]:
        """Seconds until the effect of each, until a moment."""
        number = 1
        while time.perf_counter() < end:
            number = number % NODES + 1
            script = f"document.querySelectorAll('#nodes button')[{number - 1}].click()"
            yield self._effect(script, "state-title", f"n{number}, node {number}")
            script = (
                "document.getElementById('fault').value = 'heartbeat_late';"
                "document.getElementById('fault').dispatchEvent(new Event('change'));"
                "document.querySelector('#inject button[type=submit], #inject button').click()"
            )
            yield self._effect(script, "active", "heartbeat_late")
            script = "document.querySelector('#active button').click()"
            yield self._effect(script, "active", "heartbeat_late", there=False)

    def _effect(self, script: str, where: str, text: str, there: bool = True) -> float:
        begun = time.perf_counter()
        self._browser.execute_script(script)
        self._wait(where, text, there)
        return time.perf_counter() - begun

    def _wait(self, where: str, text: str, there: bool = True) -> None:
        end = time.perf_counter() + PATIENCE
        script = f"return document.getElementById({where!r})?.textContent ?? ''"
        while (text in self._browser.execute_script(script)) is not there:
            if time.perf_counter() > end:
                raise SystemExit(f"not seen within {PATIENCE:.0f} s: {text} in {where}")
            time.sleep(NAP)


@contextmanager
def page(address: str) -> Iterator[Page]:
    """Debian's chromium by its driver."""
    from selenium import webdriver  # noqa: PLC0415

    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or "chromium"
    for switch in SWITCHES:
        options.add_argument(f"--{switch}")
    driver = webdriver.ChromeService(shutil.which("chromedriver"))
    with webdriver.Chrome(options, driver) as browser:
        yield Page(browser, address)


class Stream:
    """Somebody at the stream of all frames."""

    def __init__(self, address: str) -> None:
        self.frames = self.lost = 0
        self._over = Event()
        self._connection = HTTPConnection(address.removeprefix("http://"), timeout=PATIENCE)
        self._thread = Thread(target=self._read)
        self._thread.start()

    def _read(self) -> None:
        self._connection.request("GET", "/events?kind=frame&kind=lost")
        answer = self._connection.getresponse()
        while not self._over.is_set() and (line := answer.readline()):
            if line.startswith(b"data: "):
                event = json.loads(line[6:])
                self.frames += event["kind"] == "frame"
                self.lost += int(event["words"].split()[0]) if event["kind"] == "lost" else 0

    def end(self) -> None:
        """Go."""
        self._over.set()
        self._thread.join()
        self._connection.close()


def main() -> None:
    """A row for each of: nobody looks, the page is open, the page and a stream."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=5.0, help="of each round")
    parser.add_argument("--rounds", type=int, default=3)
    told = parser.parse_args()
    soaked = argparse.Namespace(
        twins=NODES, devices=["topcon"], heartbeat=1000, sync=0.009, sdo=100.0
    )
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        nodes = (f"  n{n}: {{device: topcon, node_id: {n}}}\n" for n in range(1, NODES + 1))
        (folder / "bench.yaml").write_text("version: 1\nnodes:\n" + "".join(nodes))
        hub = stack.enter_context(watched("hub", "--listen", ":0"))
        address = HubAddress(hub.told["host"], hub.told["port"])
        twins = stack.enter_context(
            watched("run", str(folder / "bench.yaml"), "--hub", str(address), "--control")
        )
        ours, theirs = Pipe()
        process = Process(target=master, args=(theirs, address, soaked))
        process.start()
        ours.recv()
        browser = stack.enter_context(page(twins.told["control"]))
        kinds: dict[str, Callable[[], Round]] = {
            "nobody looks": lambda: _round(ours, twins, told.seconds),
            "the page is open": lambda: _looked_at(ours, twins, told.seconds, browser),
            "and a stream": lambda: _streamed(ours, twins, told.seconds, browser),
        }
        rounds = [{kind: take() for kind, take in kinds.items()} for _ in range(told.rounds)]
        ours.send(None)
        process.join()
        for kind in kinds:
            print(row(kind, [each[kind] for each in rounds]))
        stalls = [line for line in twins.said if any(word in line for word in STALLS)]
        print(f"{len(stalls)} times the machine stood still for the twins")


def _round(
    pipe: Connection, twins: Watched, seconds: float, act: Callable[[float], Any] = lambda end: ()
) -> Round:
    busy, begun = twins.seconds, time.perf_counter()
    pipe.send(seconds)
    clicks = [*act(begun + seconds)]
    frames, answers = pipe.recv()
    took = time.perf_counter() - begun
    return Round(frames / seconds, answers, (twins.seconds - busy) / took, clicks)


def _looked_at(pipe: Connection, twins: Watched, seconds: float, browser: Page) -> Round:
    browser.open()
    try:
        return _round(pipe, twins, seconds, browser.clicks)
    finally:
        browser.close()


def _streamed(pipe: Connection, twins: Watched, seconds: float, browser: Page) -> Round:
    stream = Stream(twins.told["control"])
    told = _looked_at(pipe, twins, seconds, browser)
    stream.end()
    return told._replace(streamed=stream.frames, lost=stream.lost)


def row(kind: str, rounds: Sequence[Round]) -> str:
    """Of the table: frames/s, SDO, share of a core, clicks, the stream."""

    def late(times: Sequence[float]) -> str:
        if not times:
            return ""
        cut = quantiles(times, n=100)
        return f"{median(times) * 1e3:.1f} ms | {cut[98] * 1e3:.1f} ms"

    answers = [time for each in rounds for time in each.answers]
    clicks = [time for each in rounds for time in each.clicks]
    frames, share = median(each.frames for each in rounds), median(each.share for each in rounds)
    told = f"| {kind} | {frames:.0f} | {late(answers)} | {share:.0%} | {late(clicks) or '|'} |"
    streamed, lost = sum(each.streamed for each in rounds), sum(each.lost for each in rounds)
    return told + (f" {streamed} streamed, {lost} lost" if streamed else "")


if __name__ == "__main__":
    sys.exit(main())
