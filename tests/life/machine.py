"""A hypothesis state machine: the random life of a twin, rule by rule."""

from contextlib import contextmanager
from random import Random

from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule, run_state_machine_as_test

from benchmarks.fuzz.events import (
    SHORT_WAITS,
    WAITS,
    Clear,
    Frames,
    Power,
    Send,
    Wait,
    change,
    inject,
)
from benchmarks.fuzz.story import story
from benchmarks.fuzz.world import World
from canopen_twins.bus import identifiers
from canopen_twins.bus.frame import Frame

BURST = 100  # frames behind whatever happens
NODE_ID = 5
seeds = st.integers(0, 2**32 - 1)


class Life(RuleBasedStateMachine):
    """What happens to one twin; a subclass says to which."""

    device = ""
    sent = 0
    """Frames, of all lives."""
    found = None
    """The first world in which something did not hold, and what that was."""

    def __init__(self):
        super().__init__()
        self.world = World(self.device, node_id=NODE_ID)

    @contextmanager
    def watched(self):
        try:
            yield
        except Exception as failure:
            type(self).found = type(self).found or (self.world, failure)
            raise

    def do(self, seed, *events):
        """Let something happen, and send a burst of frames behind it."""
        random = Random(seed)
        with self.watched():
            for event in events:
                self.world.do(event)
            source = Frames(self.world.node, random)
            for _ in range(BURST):
                self.world.do(Send(source.one()))
                if random.random() < 0.01:
                    self.world.do(Wait(random.choice(SHORT_WAITS)))

    @rule(seed=seeds, can_id=st.integers(0, 0x7FF), data=st.binary(max_size=8))
    def frame(self, seed, can_id, data):
        self.do(seed, Send(Frame(can_id, data)))

    @rule(seed=seeds, command=st.sampled_from((0x01, 0x01, 0x02, 0x80, 0x81, 0x82)))
    def nmt(self, seed, command):
        self.do(seed, Send(Frame(identifiers.NMT, bytes([command, NODE_ID]))))

    @rule(seed=seeds, seconds=st.sampled_from(WAITS))
    def time(self, seed, seconds):
        self.do(seed, Wait(seconds))

    @rule(seed=seeds)
    def fault(self, seed):
        self.do(seed, inject(self.world.node.faults.known, Random(seed)))

    @rule(seed=seeds)
    def clear(self, seed):
        self.do(seed, Clear())

    @rule(seed=seeds, seconds=st.sampled_from(SHORT_WAITS))
    def power_cycle(self, seed, seconds):
        self.do(seed, Clear(), Power(False), Wait(seconds), Power(True))

    @rule(seed=seeds)
    def setting(self, seed):
        event = change(self.world.node.device, Random(seed))
        self.do(seed, *filter(None, [event]))

    @invariant()
    def holds(self):
        with self.watched():
            self.world.look()

    def teardown(self):
        type(self).sent += self.world.frames
        with self.watched():
            if not self.world.failed:
                self.world.end()


def lives(device, count, steps):
    """Let a device live so many lives of so many steps.

    Returns:
        The frames that were sent, and the story of the failure as a scenario, if there was one.
    """
    machine = type("OneLife", (Life,), {"device": device})
    chosen = settings(
        max_examples=count,
        stateful_step_count=steps,
        phases=[Phase.generate],  # a failure is made short by living through it again
        suppress_health_check=list(HealthCheck),  # a slow machine is none of its business
        deadline=None,
        database=None,
    )
    try:
        run_state_machine_as_test(machine, settings=chosen)
    except Exception:
        if machine.found is None:
            raise
        return machine.sent, story(*machine.found)
    return machine.sent, ""
