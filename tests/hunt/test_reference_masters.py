"""The masters of docs/examples/masters, in simulated time, through one fault after the other."""

import importlib
from pathlib import Path

import canopen
import pytest

from canopen_twins import Bench, simulated_time

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples" / "masters"
LASTS, UNTIL_BACK = 2.0, 8.0  # seconds

EVERYWHERE = [
    ("sdo_abort", {}),
    ("sdo_silence", {"times": 2}),
    ("sdo_late", {"seconds": 0.31, "times": 0}),
    ("sdo_wrong_index", {"times": 3}),
    ("heartbeat_stopped", {}),
    ("heartbeat_late", {"seconds": 1.0}),
    ("heartbeat_wrong_state", {"state": 4}),
    ("boot_up_lost", {}),
    ("boot_up_repeated", {"repeats": 2, "seconds": 0.3}),
    ("reset_loop", {"seconds": 0.5, "times": 3}),
    ("power_cycle", {"seconds": 0.01}),
    ("brown_out", {}),
    ("frame_lost", {"probability": 0.5}),
    ("frame_doubled", {}),
    ("frame_jitter", {"seconds": 0.1}),
    ("bus_off", {"seconds": 2.0}),
]


def topcon():
    bench = Bench("topcon", node_id=5, load="resistor 8", timing="typical")
    own = [
        ("interlock_open", {}),
        ("lasting_error", {"number": 0x23}),
        ("emcy_storm", {"seconds": 0.01}),
        ("sdo_wrong_toggle", {}),
        ("sdo_wrong_size", {}),
        ("sdo_stall", {}),
    ]
    return bench, own, lambda: 990 <= value(bench, 0x2020) <= 1010 and value(bench, 0x2010) == 1000


def charger():
    bench = Bench("charger", timing="typical", noise=0)
    own = [("error", {"number": 0x0B}), ("hardware_release_lost", {}), ("pdo_frozen", {})]
    return bench, own, lambda: value(bench, 0x6000, 1) == 0x29 and value(bench, 0x2002, 8) == 20_000


def gateway():
    bench = Bench("gateway", timing="typical", config="gateway_plant.yaml")
    own = [
        ("link_cut", {}),
        ("sdo_transmit_overflow", {}),
        ("partner_lost", {}),
        ("reset", {"unit": "governor"}),
        ("pdo_missing", {}),
    ]
    return bench, own, lambda: value(bench, 0x2003, 1) == value(bench, 0x2005) == 0


def value(bench, index, sub=0):
    return int.from_bytes(bench.twin.node.slave.entry(index, sub).read(), "little", signed=True)


@pytest.mark.parametrize("device", [topcon, charger, gateway], ids=lambda device: device.__name__)
def test_it_is_back_after_every_fault(device, monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    name = f"{device.__name__}_master"
    master = importlib.import_module(name)
    bench, own, is_well = device()
    faults = EVERYWHERE + own
    lost = []
    for number, (fault, parameters) in enumerate(faults):
        begins = 5 + number * (LASTS + UNTIL_BACK)
        bench.clock.at(begins, lambda fault=fault, given=parameters: bench.inject(fault, **given))
        bench.clock.at(begins + LASTS, lambda fault=fault: bench.clear(fault))
        ends = begins + LASTS + UNTIL_BACK - 0.01
        bench.clock.at(ends, lambda fault=fault: None if is_well() else lost.append(fault))
    with simulated_time(bench, name):
        network = canopen.Network()
        network.connect(interface="socketcan", channel="can0")
        master.main(network, seconds=5 + len(faults) * (LASTS + UNTIL_BACK))
        network.disconnect()
    assert lost == []
