"""A twin as the slave that is tested: on a bench, in simulated time, with errors on demand."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial

from canopen_twins.bench.bench import Bench
from canopen_twins.conform.bus import SimulatedBus
from canopen_twins.conform.run import conform
from canopen_twins.conform.tester import Provocation, Slave
from canopen_twins.conform.topic import Topic
from canopen_twins.device.device import Device
from canopen_twins.scenario.verdict import Verdict


def slave_of(name: str, device: Device, provocations: Sequence[Provocation] = ()) -> Slave:
    """What a tester has to know of a slave: what its twin has."""
    return Slave(name, device.node_id, device.dictionary(), device.eds, provocations)


def conform_twin(name: str, device: Device, wanted: Iterable[Topic] | None = None) -> Verdict:
    """Play topics against a twin, all of them if none are named."""
    bench = Bench({name: device})
    faults = [
        fault
        for fault, told in device.faults.items()
        if told.clear is not None
        and all(parameter.default is not None for parameter in told.parameters.values())
    ]
    provocations = [partial(_injected, bench, fault) for fault in faults]
    return conform(SimulatedBus(bench.segment), slave_of(name, device, provocations), wanted)


@contextmanager
def _injected(bench: Bench, fault: str) -> Iterator[None]:
    """What latches is gone with the supply."""
    bench.inject(fault)
    try:
        yield
    finally:
        bench.clear()
        bench.power_off()
        bench.power_on()
