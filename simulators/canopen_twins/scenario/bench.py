"""A bench on which a scenario is played, while somebody else's master lives through it."""

from canopen_twins.bench.bench import Bench
from canopen_twins.scenario import Player, Scenario, Verdict, finish


class ScenarioBench(Bench):
    """The twins of a scenario with power on, and its steps on their clock.

    Whoever moves the clock meets what happens: `bench.run(5)`, or a master in simulated time.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        super().__init__({name: spec.create() for name, spec in scenario.nodes.items()})

    def _begin(self) -> None:
        scenario = self._scenario
        if scenario.bit_rate is not None:
            self.segment.limit(scenario.bit_rate)
        nodes = {name: twin.node for name, twin in self.twins.items()}
        self._player = Player(scenario, self.segment, nodes)
        self._player.start()
        super()._begin()

    @property
    def done(self) -> bool:
        """Whether every step has been carried out and every expectation decided."""
        return self._player.done

    @property
    def verdict(self) -> Verdict:
        """What has been found so far; what is not decided by now counts as an error."""
        return self._player.verdict

    def finish(self) -> None:
        """Let time pass until it is done."""
        finish(self._player, self.segment)
