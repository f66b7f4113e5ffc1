"""How long each order holds the thread of the twins: `python -m benchmarks.orders [DEVICE...]`.

A frame that comes meanwhile is answered after it. CPU time, the best of some goes each, as other
work on the machine makes it longer. Of each kind of order the worst is told, with its name: of
`inject` the worst fault, of `start` the worst scenario that is shipped. A boot is the timer's,
after the boot time, not the order's.
"""

import gc
import sys
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields
from time import thread_time
from typing import Any

from canopen_twins import devices
from canopen_twins.bench.twin import carry_out, each_value
from canopen_twins.bus.segment import Segment
from canopen_twins.device.node import Node
from canopen_twins.device.settings import declaration
from canopen_twins.diagnosis.why import why
from canopen_twins.errors import UserError
from canopen_twins.faults import connect
from canopen_twins.files.shipped import scenario_file, scenarios
from canopen_twins.live import garbage
from canopen_twins.live.control import view
from canopen_twins.live.orders import Portions
from canopen_twins.scenario.started import read_text, start_now, stop_now

GOES = 3
NAMES = ("topcon", "charger", "gateway")


class Held:
    """A device on a bus of its own, and how long its thread was held, by kind and name."""

    def __init__(self, device: str) -> None:
        self.times: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
        self._segment: Segment[Node] = Segment()
        self._node = connect(
            self._segment, devices.create(device, node_id=5, timing="typical"), device
        )
        self._node.power_on()
        self._pass(30)
        gc.collect()
        with garbage.in_portions():  # as a run has it
            self._measure(device)

    def _measure(self, device: str) -> None:
        for _ in range(GOES):
            self._supply()
            self._look()
        for fault in self._node.faults.known:
            for _ in range(GOES):
                self._fault(fault)
        for name in self._live():
            value = getattr(self._node.device.settings, name)
            for _ in range(GOES):
                self._order("set", {name: value}, name=name)
                self._pass(0.3)
        for name in scenarios():
            if name.startswith(device):
                for _ in range(GOES):
                    self._scenario(name)

    def _pass(self, seconds: float) -> None:
        self._segment.advance_to(self._segment.clock.now + seconds)

    def _note(self, kind: str, name: str, action: Callable[[], Any]) -> None:
        begun = thread_time()
        action()
        self.times[kind][name].append(thread_time() - begun)

    def _order(self, word: str, *arguments: Any, name: str = "") -> None:
        self._note(word, name, lambda: carry_out(self._segment, self._node, word, *arguments))

    def _supply(self) -> None:
        self._order("power_off")
        self._pass(1)
        self._order("power_on", {})
        longest = 0.0
        while self._node.slave is None:
            begun = thread_time()
            self._segment.advance_to(self._segment.clock.next_deadline)
            longest = max(longest, thread_time() - begun)
        self.times["(boot)"][""].append(longest)
        self._pass(5)

    def _fault(self, name: str) -> None:
        try:
            self._order("inject", name, {}, name=name)
        except UserError:  # it wants to be told more, or the device has no such thing
            return
        self._pass(0.2)
        self._order("clear", name, name=name)
        self._pass(0.5)
        if self._node.slave is None:
            self._supply()

    def _live(self) -> Iterator[str]:
        kind = type(self._node.device.settings)
        return (each.name for each in fields(kind) if declaration(each, kind).get("live"))

    def _look(self) -> None:
        self._note("state", "", lambda: view.node_state(self._node))
        self._note("why", "", lambda: why(self._node, ()))
        for kind, items in (
            ("values, a portion", each_value(self._node, ())),
            ("objects, a portion", view.objects(self._node)),
        ):
            self.times[kind][""].append(longest_of(view.in_portions(items)))

    def _scenario(self, name: str) -> None:
        with scenario_file(name) as path:
            text = path.read_text("utf-8")
        try:
            scenario = read_text(name, text, self._segment.nodes)
        except UserError:  # it is about other nodes
            return
        players: list[Any] = []
        self._note("start", name, lambda: players.append(start_now(self._segment, scenario, text)))
        self._pass(0.2)
        if not players[0].done:
            self._note("stop", name, lambda: stop_now(self._segment, players[0]))
        players[0].leave()
        self._pass(1)


def longest_of(portions: Portions[Any]) -> float:
    """Seconds of the longest of some portions."""
    longest, over = 0.0, False
    while not over:
        begun = thread_time()
        try:
            next(portions)
        except StopIteration:
            over = True
        longest = max(longest, thread_time() - begun)
    return longest


def main(names: Sequence[str]) -> None:
    """A row for each kind of order, a column for each device."""
    held = {name: Held(name).times for name in names}
    print(f"| order | {' | '.join(names)} |\n| --- |{' ---: |' * len(names)}")
    for kind in held[names[0]]:
        told = []
        for times in held.values():
            worst, which = max((min(each), name) for name, each in times[kind].items())
            told.append(f"{worst * 1e3:.1f} ms{f', {which}' if which else ''}")
        print(f"| {kind} | {' | '.join(told)} |")


if __name__ == "__main__":
    main(sys.argv[1:] or NAMES)
