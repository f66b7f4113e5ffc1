"""Gateway, governor and engine at rest: main cycles pass in leaps, and no frame is another."""

from random import Random

import pytest

from canopen_twins import Bench
from canopen_twins.devices.gateway.model import settled

START = "000#0101"
NEVER_STILL = -1.0


def operational(**settings):
    bench = Bench("gateway", run=True, autostart=True, **settings)
    bench.run(0.5)
    bench.send(START)
    return bench


def steps_of(bench, seconds):
    system, steps = bench.device.system, []
    step = system.step
    system.step = lambda dt: (steps.append(dt), step(dt))
    bench.run(seconds)
    del system.step
    return steps


def test_at_rest_it_sends_tpdos_without_being_woken():
    bench = operational()
    assert len(steps_of(bench, 1.0)) > 120
    bench.run(30.0)
    before = len(bench.trace)
    assert len(steps_of(bench, 60.0)) <= 2
    assert len(bench.trace) - before in range(60 * 74, 60 * 76)  # TPDO4 comes with every main cycle


def test_without_tpdos_it_is_not_woken():
    bench = operational()
    bench.send("000#8001")
    bench.run(30.0)
    assert len(steps_of(bench, 3600.0)) <= 2


ACTS = (
    lambda bench, dice: bench.send(f"601#400120{1 + dice.randrange(4):02d}00000000"),
    lambda bench, dice: bench.send(f"201#{dice.randrange(1 << 16):04X}000000000000"),
    lambda bench, dice: bench.send(f"301#{dice.randrange(1 << 16):04X}001000200030"),
    lambda bench, dice: bench.send("702#05"),
    lambda bench, dice: bench.set(load=dice.randrange(200)),
    lambda bench, dice: bench.set(run=dice.random() < 0.5),
    lambda bench, dice: bench.send(f"000#{dice.choice(['80', '02', '01', '01'])}01"),
    lambda bench, dice: bench.inject("link_drop", count=dice.randrange(1, 5)),
    lambda bench, dice: bench.inject("link_cut"),
    lambda bench, dice: bench.report,
    lambda bench, dice: bench.clear(),
)


def lived(seed):
    """A life with long rests, and everything at odd times."""
    dice, bench = Random(seed), operational()
    for _ in range(8):
        bench.run(dice.choice([0.0013, 0.4, 22.0]) + dice.randrange(16000) / 1e6)
        dice.choice(ACTS)(bench, dice)
    bench.run(2.0)
    return [str(record) for record in bench.trace]


@pytest.mark.parametrize("seed", range(2))
def test_no_frame_is_another_than_without_rest(seed, monkeypatch):
    leaping = lived(seed)
    monkeypatch.setattr(settled, "UNSEEN", NEVER_STILL)
    assert leaping == lived(seed)
