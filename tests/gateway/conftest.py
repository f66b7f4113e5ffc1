import csv
from pathlib import Path

import pytest
import yaml

from canopen_twins import Bench
from canopen_twins.devices.gateway.model.errors import assignment
from canopen_twins.devices.gateway.model.parameters import catalogue, scaling
from canopen_twins.devices.gateway.model.state import MasterCommand
from canopen_twins.devices.gateway.model.system import System
from canopen_twins.devices.gateway.model.unit import Options, Tables

OD = Path(__file__).parents[2] / "od"

PLAIN = {  # no CANopen sensors and switch functions: nothing is faulty without RPDOs
    "governor": dict.fromkeys((4900, 4901, 4906, 4917, 4827, 4835), 0)
}


def rows(name):
    return list(csv.DictReader((OD / name).read_text().splitlines()))


@pytest.fixture(scope="session")
def tables():
    parameters = catalogue(rows("gateway_parameters.csv"))
    bits = assignment(yaml.safe_load((OD / "gateway_errors.yaml").read_text()))
    return Tables(parameters, scaling(parameters, rows("gateway_scaling.csv")), bits)


class Rig:
    """A system with its master's hands: `run` tells (milliseconds, message) of what was sent."""

    def __init__(self, tables, *configurations, **options):
        self.system = System(tables, Options(**options))
        for configuration in configurations:
            self.system.configure(configuration)
        self.governor, self.gateway = self.system.governor, self.system.gateway
        self.governor.operation.run = self.governor.operation.autostart = True
        self.now = 0.0

    def run(self, seconds):
        end = self.now + seconds
        sent = []
        while self.now < end - 1e-9:
            rest = min(self.system.rest, end - self.now)
            self.system.step(rest)
            self.now = round(self.now + rest, 6)
            sent += [(round(self.now * 1000, 3), message) for message in self.system.outbox]
            self.system.outbox.clear()
        return sent

    def on(self):
        self.system.power_on()
        self.run(0.25)
        return self

    def operational(self):
        self.on()
        self.system.command(MasterCommand.OPERATIONAL)
        self.run(0.05)
        return self

    @property
    def word(self):
        return self.system.value(0x2005, 0)


@pytest.fixture
def rig(tables):
    """Build a system from configurations and options; with none, from the defaults."""
    return lambda *configurations, **options: Rig(tables, *configurations, **options)


@pytest.fixture
def plain(rig):
    """Build a system without CANopen inputs."""
    return lambda *configurations, **options: rig(PLAIN, *configurations, **options)


@pytest.fixture
def configured(tmp_path):
    """Build a bench with a booted gateway, node 1, from parameters of both units and settings.

    Its engine starts by itself.
    """

    def configured(governor=(), gateway=(), **settings):
        file = tmp_path / "configuration.yaml"
        units = {"governor": {**PLAIN["governor"], **dict(governor)}, "gateway": dict(gateway)}
        file.write_text(yaml.safe_dump({"version": 1, **units}))
        bench = Bench("gateway", config=str(file), **{"run": True, "autostart": True, **settings})
        bench.run(0.3)
        return bench

    return configured


@pytest.fixture
def bench():
    """A gateway as delivered, node 1, booted: all PDOs of the manual's examples, engine started."""
    bench = Bench("gateway", run=True, autostart=True)
    bench.run(0.3)
    return bench
