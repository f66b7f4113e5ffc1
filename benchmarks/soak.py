"""Endurance: `python -m benchmarks.soak --seconds 600` loads twins in real time and watches them.

Mixed twins in one process on a hub, or on a bus of python-can; each has a heartbeat, TopCons send
a TPDO of 8 bytes for every SYNC, and a master reads objects without pause between its SYNCs.

A machine that stands still for a moment makes twins late, and has them catch up; where it does so
for a second their time is shorter, and heartbeats are not judged.

Invariants: no heartbeat is lost and no SYNC is without its TPDOs, every SDO is answered,
memory does not grow, and the processes end when they are told to.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, nullcontext
from itertools import cycle, pairwise
from math import inf
from pathlib import Path
from statistics import median

import can
from can.interfaces.socketcan import SocketcanBus

from benchmarks.processes import Sample, Watched, judged, percentiles, slope, watched
from canopen_twins.bus.frame import Frame
from canopen_twins.bus.hub.client import HubBus
from canopen_twins.bus.hub.protocol import HubAddress
from canopen_twins.live.port import CanSocket, PythonCan

DEVICES = ("topcon", "charger", "gateway")
STEP = 0.016  # seconds; the cycle of a gateway
LATE = 0.005  # seconds; a deadline of a PC that is busy otherwise
ANSWERED = 5.0  # seconds for an SDO
REPEATED = 1.0  # seconds until somebody who may be booting is asked again
SETTLED = 0.2  # seconds
LEFT_OUT = "of real time are left out"
ATTEMPTS = 10
WARM_UP = 3.0  # seconds, at most
LONG, STEEPEST = 590.0, 5.0  # seconds, MB an hour: before that memory has not settled
READ = bytes.fromhex("4000100000000000")  # 0x1000, which every device has
HEARD = [{"can_id": base, "can_mask": 0x780} for base in (0x580, 0x700)]
SYNC = Path(__file__).with_name("c_sync.c")


class Master:
    """Configures the twins, then asks and listens until its time is over."""

    def __init__(self, bus: PythonCan | CanSocket, options: argparse.Namespace) -> None:
        self._bus = bus
        self._options = options
        self.heartbeats: dict[int, list[float]] = {n: [] for n in range(1, options.twins + 1)}
        named = zip(self.heartbeats, cycle(options.devices), strict=False)
        self.topcons = {node_id for node_id, device in named if device == "topcon"}
        self.tpdos = self.syncs = self.frames = self.unanswered = 0
        self.answers: list[float] = []
        self.periods = dict.fromkeys(self.heartbeats, 0.0)
        self._asked: dict[int, float] = {}  # whom, and when: one transfer at a time with each
        self._turns = deque(self.heartbeats)
        self.counts = False

    def configure(self) -> None:
        """Heartbeats everywhere, TPDO 1 of a TopCon with every SYNC, everybody operational.

        A device has periods of its own that takes none of ours.
        """
        period = self._options.heartbeat.to_bytes(2, "little")
        for node_id in self.heartbeats:
            self._ask(node_id, bytes.fromhex("2b171000") + period + bytes(2))
            told = self._ask(node_id, bytes.fromhex("4017100000000000"))
            self.periods[node_id] = int.from_bytes(told[4:6], "little") / 1e3
            if node_id in self.topcons:
                self._ask(node_id, bytes.fromhex("2f00180201000000"))
        self._send(0x000, bytes([1, 0]))

    def work(self, seconds: float, samples: Mapping[Watched, list[Sample]]) -> None:
        """Ask, synchronise and listen for so long."""
        begun = now = time.monotonic()
        next_sync = inf if self._options.by_c else begun
        next_sdo = next_look = begun
        while now < begun + seconds:
            if now >= next_sync:
                self._send(0x080, b"")
                self.syncs += self.counts
                next_sync += self._options.sync
            if now >= next_sdo:
                self._request(now)
                next_sdo += 1 / self._options.sdo
            if now >= next_look:
                for process, list_of in samples.items():
                    list_of.append(Sample(now - begun, process.memory))
                next_look += 1.0
            self._hear(max(0.0, min(next_sync, next_sdo) - time.monotonic()))
            now = time.monotonic()

    def settle(self) -> None:
        """Hear what is still on its way."""
        end, least = time.monotonic() + ANSWERED, time.monotonic() + SETTLED
        while (now := time.monotonic()) < end and (self._asked or now < least):
            self._hear(0.05)
        self.unanswered += len(self._asked)

    def _request(self, now: float) -> None:
        for _ in range(len(self._turns)):
            node_id = self._turns[0]
            self._turns.rotate(-1)
            if now - self._asked.get(node_id, now) > ANSWERED:
                del self._asked[node_id]
                self.unanswered += 1
            if node_id not in self._asked:
                self._asked[node_id] = now
                self._send(0x600 + node_id, READ)
                return

    def _hear(self, wait: float) -> None:
        frame = self._bus.receive(wait)
        if frame is None:
            return
        now = time.monotonic()
        node_id, kind = frame.can_id & 0x7F, frame.can_id & ~0x7F
        self.frames += self.counts
        if kind == 0x700 and self.counts and frame.data != b"\x00":
            self.heartbeats[node_id].append(now)
        elif kind == 0x180 and node_id in self.topcons:
            self.tpdos += self.counts
        elif kind == 0x580 and (asked := self._asked.pop(node_id, None)) is not None:
            self.answers.append(now - asked)

    def _ask(self, node_id: int, data: bytes) -> bytes:
        for _ in range(ATTEMPTS):  # it may still be booting
            self._send(0x600 + node_id, data)
            end = time.monotonic() + REPEATED
            while (left := end - time.monotonic()) > 0:
                frame = self._bus.receive(left)
                if frame is not None and frame.can_id == 0x580 + node_id:
                    return frame.data
        raise SystemExit(f"node {node_id} does not answer")

    def _send(self, can_id: int, data: bytes) -> None:
        self._bus.send(Frame(can_id, data))


def main() -> int:
    """1 if an invariant does not hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--twins", type=int, default=3, help="1..127")
    parser.add_argument("--devices", nargs="+", default=DEVICES, help="taken in turns")
    parser.add_argument("--heartbeat", type=int, default=100, help="its period in ms")
    parser.add_argument("--sync", type=float, default=0.01, help="its period in s")
    parser.add_argument("--sdo", type=float, default=100.0, help="requests a second")
    parser.add_argument("--interface", help="of python-can; a hub of its own if there is none")
    parser.add_argument("--channel", default="vcan0")
    parser.add_argument("--timing", help="that of all twins, as of `run`")
    text = "SYNC is sent and TPDOs are counted by a program in C, on vcan0"
    parser.add_argument("--by-c", action="store_true", help=text)
    options = parser.parse_args()
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        file = folder / "bench.yaml"
        timing = f", timing: {options.timing}" if options.timing else ""
        nodes = (
            f"  n{n}: {{device: {device}, node_id: {n}{timing}}}\n"
            for n, device in zip(range(1, options.twins + 1), cycle(options.devices), strict=False)
        )
        file.write_text("version: 1\nnodes:\n" + "".join(nodes))
        processes = {}
        if options.interface:
            place = ("-i", options.interface, "-c", options.channel)
        else:
            hub = processes["hub"] = stack.enter_context(watched("hub", "--listen", ":0"))
            address = HubAddress(hub.told["host"], hub.told["port"])
            place = ("--hub", str(address), "-c", options.channel)
        processes["twins"] = stack.enter_context(
            watched("run", str(file), "--stalls", "catch-up", *place)
        )
        bus: can.BusABC
        if options.interface:
            heard = HEARD if options.by_c else None
            bus = can.Bus(options.channel, options.interface, can_filters=heard)
        else:
            bus = HubBus(address, options.channel)
        program = folder / "c_sync"
        if options.by_c:
            subprocess.run(["cc", "-O2", "-o", program, SYNC], check=True)
        with bus:
            is_socket = isinstance(bus, SocketcanBus)
            master = Master(CanSocket(bus.socket) if is_socket else PythonCan(bus), options)
            return _soak(master, options, processes, program)


def _soak(
    master: Master, options: argparse.Namespace, processes: Mapping[str, Watched], program: Path
) -> int:
    samples: dict[Watched, list[Sample]] = {process: [] for process in processes.values()}
    master.configure()
    master.work(min(WARM_UP, options.seconds / 2), {})
    busy = {name: process.seconds for name, process in processes.items()}
    master.counts, begun = True, time.monotonic()
    with _synchronised(master, program, options.sync) if options.by_c else nullcontext():
        master.work(options.seconds, samples)
    took = time.monotonic() - begun
    shares = {name: (each.seconds - busy[name]) / took for name, each in processes.items()}
    master.counts = False
    master.settle()
    broken = [*_heard(master, took), *_of_processes(processes, samples, shares)]
    if any(LEFT_OUT in line for process in processes.values() for line in process.said):
        print("the machine was away for a second or more: heartbeats are not judged")
        broken = [each for each in broken if "heartbeats" not in each]
    return judged(broken)


@contextmanager
def _synchronised(master: Master, program: Path, period: float) -> Iterator[None]:
    """SYNC and what comes of it are for a program in C, which takes less of a core for it."""
    command = [str(program), str(round(1e6 * period)), *map(str, sorted(master.topcons))]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            yield
        finally:
            process.terminate()
            told = process.communicate()[0]
    master.syncs, master.tpdos = map(int, told.split())
    master.frames += master.syncs + master.tpdos


def _heard(master: Master, took: float) -> Iterator[str]:
    """Tell what has come; gives what should not be."""
    lost, late, jitter = 0, 0, []
    for node_id, times in master.heartbeats.items():
        if len(times) < 3:
            lost += max(0, int(took / master.periods[node_id]) - 1 - len(times))
            continue
        intervals = [after - before for before, after in pairwise(times)]
        said, span = master.periods[node_id], times[-1] - times[0]
        is_as_said = abs(span / len(intervals) - said) <= STEP / 2
        period = said if is_as_said else median(intervals)  # it may count in steps of its own
        periods = round(span / period)
        lost += max(0, periods - len(intervals))
        mean = span / max(periods, len(intervals))
        if abs(mean - said) > STEP:
            yield f"node {node_id} has heartbeats of {mean:.3f} s"
        lags = [abs(interval - period) for interval in intervals]
        late += sum(lag > LATE for lag in lags)
        jitter += lags
    topcons = len(master.topcons)
    missing = max(0, (master.syncs - 1) * topcons - master.tpdos)
    answers, unanswered = master.answers, master.unanswered
    print(
        f"{len(master.heartbeats)} twins, {took:.0f} s, {master.frames / took:.0f} frames/s heard"
    )
    print(f"heartbeats: {len(jitter)}, lost {lost}, by more than 5 ms off {late}")
    print(f"jitter of a heartbeat: {percentiles(jitter)}")
    print(f"TPDOs: {master.tpdos} for {master.syncs} SYNCs, {topcons} a SYNC, missing {missing}")
    print(f"SDO: {len(answers)} answered, {unanswered} not: {percentiles(answers)}")
    yield from [f"{lost} heartbeats are lost"] if lost else []
    yield from [f"{missing} TPDOs are lost"] if missing else []
    yield from [f"{unanswered} SDOs are not answered"] if unanswered else []


def _of_processes(
    processes: Mapping[str, Watched],
    samples: Mapping[Watched, list[Sample]],
    shares: Mapping[str, float],
) -> Iterator[str]:
    """The same of what they took, and how they end."""
    for name, process in reversed(processes.items()):
        rise = slope(samples[process])
        told = f"{shares[name]:.0%} of a core, {process.memory:.0f} MB"
        print(f"{name}: {told}, growing by {rise:.1f} MB an hour")
        if samples[process][-1].time >= LONG and rise > STEEPEST:
            yield f"{name} grows by {rise:.1f} MB an hour"
        if code := process.end():
            yield f"{name} ends with {code}"
        stalls = [line for line in process.said if "stood still" in line or LEFT_OUT in line]
        print(f"{name}: {len(stalls)} times the machine stood still for it")
        yield from (f"{name} said: {line.strip()}" for line in process.said if line not in stalls)


if __name__ == "__main__":
    sys.exit(main())
